"""The page of the viewer: its HTML and its look."""

from __future__ import annotations

import html
import json
from pathlib import Path

from ._html_page import html_page
from ._text import write_text
from ._viewer import Viewer
from ._viewer_data import viewer_record
from ._viewer_script import CATCH, SCRIPT

_STYLE = """
:root { color-scheme: light dark; --text: #1d2126; --soft: #5b6470; --line: #d4d9df;
  --page: #ffffff; --stage: #f3f5f7; --mark: #1f5fa8; --bad: #a3242b; }
@media (prefers-color-scheme: dark) { :root { --text: #e8eaed; --soft: #a3abb5; --line: #3a414a;
  --page: #15181c; --stage: #1e2329; --mark: #7fb4f0; --bad: #ff8a8a; } }
* { box-sizing: border-box; }
body { margin: 0; font: 15px/1.45 system-ui, sans-serif; color: var(--text);
  background: var(--page); }
main { max-width: 70rem; margin: 0 auto; padding: 1rem 1.25rem 1.5rem; }
h1 { font-size: 1.35rem; margin: 0; line-height: 1.25; overflow-wrap: anywhere; }
header, .row { display: flex; flex-wrap: wrap; gap: 0.6rem 1.25rem; align-items: center; }
header { justify-content: space-between; margin-bottom: 0.75rem; }
fieldset { border: 0; margin: 0; padding: 0; display: flex; min-width: 0; flex-wrap: wrap; }
legend { position: absolute; clip-path: inset(50%); width: 1px; height: 1px; overflow: hidden; }
fieldset label { border: 1px solid var(--line); padding: 0.3rem 0.8rem; cursor: pointer;
  margin-left: -1px; position: relative; overflow-wrap: anywhere; }
fieldset label:first-of-type { border-radius: 0.4rem 0 0 0.4rem; }
fieldset label:last-of-type { border-radius: 0 0.4rem 0.4rem 0; }
fieldset input { position: absolute; opacity: 0; inset: 0; margin: 0; cursor: pointer; }
fieldset label:has(:checked) { background: var(--mark); border-color: var(--mark);
  color: var(--page); }
fieldset label:has(:focus-visible), button:focus-visible,
summary:focus-visible, input:focus-visible { outline: 3px solid var(--mark); outline-offset: 2px; }
button { font: inherit; color: inherit; background: var(--page); border: 1px solid var(--line);
  border-radius: 0.4rem; padding: 0.3rem 0.8rem; cursor: pointer; }
button:hover:enabled { border-color: var(--mark); }
button:disabled, input:disabled { opacity: 0.45; cursor: default; }
.stage { display: grid; grid-template-columns: 1fr auto; border-radius: 0.5rem;
  background: var(--stage); height: clamp(18rem, 62vh, 44rem); overflow: hidden; }
.scene { position: relative; min-width: 0; }
canvas { position: absolute; width: 100%; height: 100%; touch-action: none; cursor: grab; }
canvas:active { cursor: grabbing; }
#guide { position: absolute; left: 0; bottom: 0; width: 15rem; height: 6rem; pointer-events: none;
  font-size: 12px; fill: var(--soft); stroke: var(--soft); }
#guide text { stroke: none; }
.bar { position: relative; width: 6rem; margin: 2.6rem 0 1.2rem; }
#colours { position: absolute; left: 0.5rem; top: 0; bottom: 0; width: 1rem;
  border-radius: 0.2rem; }
.bar p { position: absolute; margin: 0; left: 0.5rem; bottom: calc(100% + 0.5rem);
  font-size: 0.85rem; color: var(--soft); white-space: nowrap; }
.bar .tick { position: absolute; left: 1.5rem; transform: translateY(50%); font-size: 0.85rem;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
.bar .tick::before { content: ""; display: inline-block; width: 0.35rem; height: 1px;
  background: var(--soft); vertical-align: middle; margin-right: 0.3rem; }
#mark { position: absolute; left: 0; width: 0; height: 0; transform: translateY(50%);
  border: 0.35rem solid transparent; border-left: 0.5rem solid var(--text); border-right: 0; }
.row { margin-top: 0.75rem; }
#frame { flex: 1 1 14rem; min-width: 8rem; accent-color: var(--mark); }
#play { width: 5.5rem; }
#when { min-width: 10rem; text-align: right; font-variant-numeric: tabular-nums; }
.said { margin: 0.6rem 0 0; font-variant-numeric: tabular-nums; }
.soft { color: var(--soft); }
#message { color: var(--bad); font-weight: 600; margin: 0 0 0.75rem; }
details { margin-top: 0.75rem; color: var(--soft); }
details p { margin: 0.4rem 0; max-width: 46rem; }
.undrawn .stage { height: 14rem; }
.undrawn .scene > *, .undrawn #here, .undrawn .look { display: none; }
[hidden] { display: none !important; }
@media (max-width: 40rem) { main { padding: 0.75rem; } .bar { width: 5.6rem; }
  .stage { height: 60vh; } }
@media print { .row, #hint { display: none; } }
"""

_BODY = """
<main id="viewer">
<header><h1>@title@</h1>
<fieldset id="layers"><legend>Layer</legend></fieldset></header>
<p id="message" role="alert" hidden></p>
<noscript><p>This page draws with JavaScript, which is switched off.</p></noscript>
<div class="stage">
<div class="scene"><canvas id="canvas" role="img"
 aria-label="The object in the colours of this layer; its range is told below"></canvas>
<svg id="guide" aria-hidden="true"></svg></div>
<div class="bar" id="bar" role="img"><p id="unit"></p><div id="colours"></div>
<div id="ticks"></div><div id="mark" hidden></div></div>
</div>
<div class="row">
<button id="play" type="button">Play</button>
<input id="frame" type="range" min="0" max="0" step="1" value="0" aria-label="Time">
<output id="when" for="frame"></output>
</div>
<p class="said" id="said" role="status"></p>
<p class="said soft" id="here">Point at the object to read a value.</p>
<div class="row">
<fieldset id="units"><legend>Unit of temperatures</legend>
<label><input type="radio" name="unit" value="K" checked>K</label>
<label><input type="radio" name="unit" value="C">°C</label></fieldset>
<label class="look" id="dotted"><input type="checkbox" id="dots"> Readings</label>
<label class="look"><input type="checkbox" id="light" checked> Light</label>
<button class="look" id="reset" type="button">Reset view</button>
</div>
<details id="hint"><summary>About this picture</summary>
<p id="rounding"></p>
<p>The colours of a layer mean the same at all its times. Hatched places have no known value.
Light darkens colours that are turned away by up to 18&nbsp;%; without it they are exactly those
of the bar. Between the corners of a triangle values are linear, and where the bar is logarithmic
their logarithms. The page opens at the time at which the values differ most from place to
place.</p>
<p id="colouring"></p>
<p>Drag to turn, drag with shift or with the right button to shift, scroll or pinch to zoom. The
left and right arrow keys go through time, the space bar plays. With shift the arrow keys turn the
object; plus and minus zoom. The address of the page holds layer, time and view.</p>
</details>
</main>
"""


def write_viewer(path: Path, viewer: Viewer) -> None:
    """Write one page in HTML that shows layers [SI] on a surface [m] and needs no network.

    The page opens from disk. Values are rounded to 65534 steps of a layer's range over all times,
    which the page states; positions are in single precision.

    Arguments: `path` of the page; its folder is made if it is missing. The file is whole or
    absent.
    """
    write_text(Path(path), viewer_page(viewer))


def viewer_page(viewer: Viewer) -> str:
    """The whole page of a viewer [SI]; nothing in it is loaded from elsewhere, nor could it be."""
    policy = (
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:\">"
    )
    body = (
        _BODY.replace("@title@", html.escape(viewer.title))
        + f'<script type="application/json" id="data">{_json(viewer)}</script>\n'
        + f"<script>{SCRIPT}</script>"
    )
    return html_page(viewer.title, _STYLE, body, head=policy, script=CATCH)


def _json(viewer: Viewer) -> str:
    """The data as JSON without a character that could end its element."""
    text = json.dumps(viewer_record(viewer), allow_nan=False, separators=(",", ":"))
    for one in "<>&":
        text = text.replace(one, f"\\u{ord(one):04x}")
    return text

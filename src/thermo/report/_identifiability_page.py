"""One page in HTML, without a network, on what the data identify; rendered from its JSON alone."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from plotly.graph_objects import Figure
from plotly.offline import get_plotlyjs

from thermo.inverse import NORMAL

from ._html_page import html_page
from ._identifiability_plots import (
    correlations,
    field_maps,
    profile,
    response,
    shares,
    spectrum,
)

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 60rem; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { text-align: left; padding: 0.3rem 0.6rem; border-bottom: 1px solid #ddd; }
.identified { color: #1b6e3c; } .weak { color: #8a5a00; }
.not_identified, .at_bound { color: #a3242b; }
.plot { break-inside: avoid; }
@media print { body { max-width: none; font-size: 11pt; } .modebar { display: none; } }
"""

Record = Mapping[str, Any]


def identifiability_page(record: Record, title: str) -> str:
    """The page of an analysis [SI]; `record` is what `identifiability.json` holds."""
    left = _list(record["left_out"] or ["Nothing."], "left-out")
    made_with = ", ".join(f"{name} {value}" for name, value in record["versions"].items())
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        _list(record["sentences"], "verdicts"),
        _section("Parameters", "parameters", _parameters(record)),
        _section("What cannot be known", "unknown", _free(record)),
        *_fields(record),
        *_means(record),
        *_bands(record),
        *_shifts(record),
        *_next_runs(record),
        _section("Noise", "noise", _noise(record)),
        _section("Directions", "directions", _plots(_directions(record), "directions")),
        *_profiles(record),
        *_basins(record),
        _section("Where the readings respond", "maps", _plots(_maps(record), "maps")),
        _section("What was left out", "left", left),
        _section("Made with", "versions", html.escape(made_with)),
    ]
    return html_page(title, _STYLE, "\n".join(parts), script=get_plotlyjs())


def _section(heading: str, name: str, body: str) -> str:
    return f'<section id="{name}"><h2>{heading}</h2>\n{body}</section>'


def _list(lines: Sequence[str], name: str) -> str:
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f'<ul class="{name}">{items}</ul>'


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], kinds: Sequence[str]) -> str:
    head = "".join(f"<th>{html.escape(word)}</th>" for word in header)
    body = "".join(
        f'<tr class="{kind}">' + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
        for row, kind in zip(rows, kinds, strict=True)
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _parameters(record: Record) -> str:
    header = ["unknown", "value", "sd", "95 % interval", "profile", "informed by data", "verdict"]
    found = record["parameters"]
    rows = [
        [
            name,
            f"{item['value']:.4g} {'' if item['unit'] == '1' else item['unit']}",
            f"{item['sd']:.2g}",
            " to ".join(f"{end:.4g}" for end in item["interval95"]),
            _ends(item["profile"]),
            f"{item['informed_by_data']:.3f}",
            item["verdict"].replace("_", " "),
        ]
        for name, item in found.items()
    ]
    return _table(header, rows, [item["verdict"] for item in found.values()])


def _ends(found: Record | None) -> str:
    if found is None:
        return "not made"
    ends = ["not reached" if e is None else f"{e:.4g}" for e in (found["lower"], found["upper"])]
    return f"{' to '.join(ends)} ({found['kind']})"


def _free(record: Record) -> str:
    found = [item["combination"] for item in record["null_directions"]]
    of = " of one value each for the whole body" if record.get("fields") else ""
    return _list(found or [f"The data lead in every direction{of}."], "free")


def _within(deviation: float) -> str:
    """Half of a 95 % interval from the standard deviation of a logarithm [1]."""
    return f"{100 * np.expm1(NORMAL * deviation):.2g} %"


def _fields(record: Record) -> list[str]:
    found = record.get("fields", {})
    if not found:
        return []
    header = ["field", "known on half of the faces", "on 95 % of them", "a mean over", "controls",
              "directions that the data lead"]  # fmt: skip
    rows = [
        [name, *(_within(item["deviation"][quantile]) for quantile in ("median", "p95")),
         f"{1e3 * item['resolution_m']['median']:.2g} mm", str(item["controls"]),
         str(item["data_led"])]
        for name, item in found.items()
    ]  # fmt: skip
    surface = record["surface"]
    drawn = [
        field_maps(name, item["maps"], surface)
        for name, item in found.items()
        if surface is not None
    ]
    body = _table(header, rows, ["field"] * len(rows))
    return [_section("From place to place", "fields", f"{body}\n{_plots(drawn, 'fields')}")]


def _means(record: Record) -> list[str]:
    found = record.get("means", [])
    if not found:
        return []
    header = ["mean of", "over", "of the surface", "value", "95 % interval by slopes", "profile"]
    rows = [
        [one["quantity"], one["region"], f"{one['share']:.0%}", f"{one['value']:.4g} {one['unit']}",
         " to ".join(f"{end:.4g}" for end in one["interval95"]), _ends(one["profile"])]
        for one in found
    ]  # fmt: skip
    drawn = [
        profile(f"{one['quantity']} over {one['region']}", one["profile"], one["unit"])
        for one in found
        if one["profile"] is not None
    ]
    body = _table(header, rows, ["mean"] * len(rows))
    return [_section("Means over regions", "means", f"{body}\n{_plots(drawn, 'means')}")]


def _bands(record: Record) -> list[str]:
    found = record.get("bands", {})
    if not found:
        return []
    header = ["run", "deviation of half of the predicted temperatures [K]", "of 95 % [K]",
              "largest [K]", "readings inside the 95 % band"]  # fmt: skip
    rows = [
        [name, *(f"{item['deviation_K'][q]:.2g}" for q in ("median", "p95", "max")),
         f"{item['inside']:.1%}"]
        for name, item in found.items()
    ]  # fmt: skip
    body = _table(header, rows, ["band"] * len(rows))
    return [_section("Predictions", "bands", body)]


def _shifts(record: Record) -> list[str]:
    found = record.get("shifts", [])
    if not found:
        return []
    header = ["stated value", "too large by", "moves", "by", "in standard deviations"]
    rows = [
        [one["held"], f"{100 * np.expm1(one['doubt']):.2g} %", one["name"],
         f"{100 * np.expm1(one['relative']):+.2g} %",
         f"{one['deviations']:+.2g}"]
        for one in found
    ]  # fmt: skip
    body = _table(header, rows, ["shift"] * len(rows))
    return [_section("What a wrong stated value would do", "shifts", body)]


def _next_runs(record: Record) -> list[str]:
    found = record.get("next_runs", [])
    if not found:
        return []
    header = ["run that could be made", "direction known least, before", "after",
              "all unknowns, root mean square", "gain of information"]  # fmt: skip
    rows = [
        [one["name"], f"{one['before']:.2g}",
         f"{one['weakest'] if one['pair'] is None else one['pair']:.2g}",
         f"{one['mean']:.2g}", f"{one['gain']:.2g}"]
        for one in found
    ]  # fmt: skip
    body = _table(header, rows, ["next"] * len(rows))
    return [_section("Which run to make next", "next", f"<p>{_NEXT}</p>{body}")]


_NEXT = (
    "Standard deviations of logarithms. With two unknowns to be told apart, the direction is the "
    "worst combination of both. The gain is half the logarithm of the ratio of determinants."
)


def _noise(record: Record) -> str:
    header = ["run", "white [K]", "left in next frame", "whole frames [K]", "offsets [K]",
              "unknown of these [K]", "from", "tested"]  # fmt: skip
    rows = [
        [
            name,
            *(f"{item[key]:.2g}" for key in ("white", "correlation", "frame", "offset", "staying")),
            item["source"],
            (item["check"] or item.get("residual") or {"words": "not tested"})["words"],
        ]
        for name, item in record["noise"].items()
    ]
    return _table(header, rows, ["run"] * len(rows))


def _directions(record: Record) -> list[Figure]:
    return [
        shares(record["parameters"]),
        spectrum(record["spectrum"]),
        correlations(record["spectrum"]),
    ]


def _profiles(record: Record) -> list[str]:
    made = {n: item for n, item in record["parameters"].items() if item["profile"] is not None}
    if not made:
        return []
    figures = [profile(name, item["profile"], item["unit"]) for name, item in made.items()]
    return [_section("Profiles", "profiles", _plots(figures, "profiles"))]


def _basins(record: Record) -> list[str]:
    found = record["basins"]
    if not found:
        return []
    names = list(found[0]["values"])
    rows = [
        [*(f"{item['values'][name]:.4g}" for name in names), f"{item['chi2']:.6g}",
         f"{item['share']:.0%}"]
        for item in found
    ]  # fmt: skip
    body = _table([*names, "chi squared", "share of the starts"], rows, ["basin"] * len(rows))
    return [_section("Where fits from other starts end", "basins", body), *_scatter(record)]


def _scatter(record: Record) -> list[str]:
    found = record["scatter"]
    if found is None:
        return []
    header = ["unknown", "by noise", "as the slopes foretell", "within what draws allow",
              "share of the optimiser"]  # fmt: skip
    parts = ("names", "noise", "linear", "noise_as_foretold", "optimiser_share")
    rows = [
        [name, f"{100 * noise**0.5:.2g} %",
         "not at all" if linear is None else f"{100 * linear**0.5:.2g} %",
         "yes" if fine else "no", f"{share:.1%}"]
        for name, noise, linear, fine, share in zip(*(found[part] for part in parts), strict=True)
    ]  # fmt: skip
    body = _table(header, rows, ["scatter"] * len(rows))
    return [_section(f"Scatter over {found['draws']} draws of the noise", "scatter", body)]


def _maps(record: Record) -> list[Figure]:
    return [response(name, item) for name, item in record["maps"].items()]


def _plots(figures: Sequence[Figure], name: str) -> str:
    return "\n".join(
        '<div class="plot">'
        + figure.to_html(
            full_html=False,
            include_plotlyjs=False,
            div_id=f"{name}-{number}",
            config={"displaylogo": False, "responsive": True},
        )
        + "</div>"
        for number, figure in enumerate(figures)
    )

"""The viewer's page in a real browser: it draws, its slider works, it reads values."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from thermo.mesh import cylinder_mesh
from thermo.report._viewer import Layer, Readings, Viewer
from thermo.report._viewer_page import write_viewer
from thermo.report._viewer_prediction import boundary_triangles

_NAMES = ("chromium", "chromium-browser", "google-chrome")
BROWSER = next(filter(None, map(shutil.which, _NAMES)), None)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome is installed")

FLAGS = (
    "--headless=new", "--no-sandbox", "--no-first-run", "--disable-quic", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-logging=stderr",
    "--virtual-time-budget=2000", "--window-size=900,800", "--hide-scrollbars", "--dump-dom",
)  # fmt: skip
TIME = np.linspace(0.0, 120.0, 13)
# What a reader does: points above the middle, goes one frame on, asks for degrees Celsius.
READER = """
<script>
const box = document.getElementById("canvas").getBoundingClientRect();
const at = { clientX: box.left + box.width / 2, clientY: box.top + 0.35 * box.height };
document.getElementById("canvas").dispatchEvent(new PointerEvent("pointermove", at));
document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
document.querySelector('[value="C"]').click();
</script>
"""


def page(path: Path, more: str = "", course: np.ndarray = 1.0 + TIME / 60.0) -> Path:
    """A cylinder, 0 to 80 mm high, that is the warmer the higher, over time as `course` [1] says.

    Nothing is known of the residual of its lower half.
    """
    mesh = cylinder_mesh(0.02, 0.08, 4, 12)
    nodes, triangles = boundary_triangles(mesh)
    vertices = mesh.nodes[nodes]
    warm = 300.0 + 1000.0 * vertices[:, 2] * course[:, None]
    left = np.outer(np.cos(TIME / 20.0), vertices[:, 0] / 0.02)
    left[:, vertices[:, 2] < 0.0399] = np.nan
    layers = (
        Layer("conductivity", "W/m/K", None, 1.0 + vertices[:, 0] / 0.04, "field"),
        Layer("residual", "K", TIME, left, "residual"),
        Layer("temperature", "K", TIME, warm, "temperature"),
    )
    readings = Readings(vertices[::7], TIME, warm[:, ::7])
    write_viewer(path, Viewer("A rod & <its heat>", vertices, triangles, layers, readings))
    path.write_text(path.read_text("utf-8").replace("</body>", more + "</body>"), "utf-8")
    return path


@dataclass(frozen=True)
class Shown:
    """What a browser made of a page: its words, the data of its main element, its picture."""

    words: str
    told: dict[str, str]
    picture: np.ndarray | None


def shown(path: Path, address: str, *flags: str, picture: bool = False) -> Shown:
    folder = path.parent
    image = folder / "picture.png"
    more = [*flags, f"--user-data-dir={folder / 'browser'}"]
    if picture:
        more.append(f"--screenshot={image}")
    call = [str(BROWSER), *FLAGS, *more, f"{path.as_uri()}#{address}"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    slow = ("will-read-frequently", "GL Driver Message")
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert [line for line in said if not any(word in line for word in slow)] == []
    opened = re.search(r"<html[^>]*>", done.stdout)
    assert opened and 'data-ready="true"' in opened[0] and "data-error" not in opened[0]
    main = re.search(r'<main id="viewer"[^>]*>', done.stdout)
    assert main
    told = dict(re.findall(r'data-(\w+)="([^"]*)"', main[0]))
    pixels = np.asarray(Image.open(image).convert("RGB"), float) if picture else None
    return Shown(done.stdout, told, pixels)


def coloured(pixels: np.ndarray) -> np.ndarray:
    """The object: what has a colour, left of the bar and between heading and controls."""
    return (np.ptp(pixels, axis=-1) > 40)[70:400, 20:760]


def test_the_slider_changes_the_picture(tmp_path: Path) -> None:
    path = page(tmp_path / "rod.html")
    pictures = []
    for frame, time in ((1, "10"), (12, "120")):
        seen = shown(path, f"layer=temperature&frame={frame}&unit=K", picture=True)
        assert seen.told["layer"] == "temperature" and seen.told["unit"] == "K"
        assert (seen.told["frame"], seen.told["time"], seen.told["frames"]) == (
            str(frame), time, "13",
        )  # fmt: skip
        # Side, 24 x 12 squares, and two lids of 6 x 4^2 triangles, drawn without a fault.
        assert seen.told["triangles"] == str(2 * 24 * 12 + 2 * 6 * 4**2)
        assert seen.told["fault"] == "0"
        assert seen.picture is not None
        pictures.append(seen.picture)
        assert f"Temperature at {time} s: from 300.0 K to {380 + 8 * frame * 10 / 6:.1f} K" in (
            seen.words
        )
    early, late = (coloured(one) for one in pictures)
    # A rod of 40 x 80 mm fills a good part, and at the end has many colours.
    assert early.sum() > 15_000 and late.sum() > 15_000
    colours = pictures[1][70:400, 20:760][late].astype(int) // 8
    assert len(np.unique(colours, axis=0)) > 60
    other = np.abs(pictures[0] - pictures[1])[70:400, 20:760].max(axis=-1) > 30
    assert (other & late).sum() > 0.5 * late.sum()


def test_keys_units_and_the_pointer_are_heard(tmp_path: Path) -> None:
    seen = shown(page(tmp_path / "rod.html", READER), "layer=temperature&frame=5")
    assert (seen.told["frame"], seen.told["time"], seen.told["unit"]) == ("6", "60", "°C")
    number = r"(\u2212?[\d.]+)"
    found = re.search(
        rf"Temperature under the pointer: {number} °C, at \({number}, {number}, {number}\) mm",
        seen.words,
    )
    assert found
    value, x, y, z = (float(one.replace("\u2212", "-")) for one in found.groups())
    # 300 K and 2 K for each millimetre at 60 s; the side is shown above its middle, 40 mm.
    assert value == pytest.approx(26.85 + 2.0 * z, abs=0.5)
    assert np.hypot(x, y) == pytest.approx(20.0, abs=0.3) and 47.0 < z < 70.0
    assert '<span class="tick"' in seen.words and ">50</span>" in seen.words
    assert "<title>A rod &amp; &lt;its heat&gt;</title>" in seen.words


def test_it_opens_where_temperatures_differ_most_and_goes_on_from_there(tmp_path: Path) -> None:
    # Uniform at the start, as a heated body is, and nearly so at the end.
    course = np.r_[np.linspace(0.0, 1.0, 5), np.linspace(0.9, 0.05, 8)]
    seen = shown(page(tmp_path / "rod.html", course=course), "", picture=True)
    assert (seen.told["layer"], seen.told["frame"], seen.told["time"]) == ("temperature", "4", "40")
    assert "Temperature at 40 s: from 300.0 K to 380.0 K." in seen.words
    assert seen.picture is not None
    colours = seen.picture[70:400, 20:760][coloured(seen.picture)].astype(int) // 8
    assert len(np.unique(colours, axis=0)) > 60
    slider = re.search(r'<input id="frame"[^>]*>', seen.words)
    assert slider and 'aria-valuetext="40 s (5 of 13)"' in slider[0] and "disabled" not in slider[0]
    # The slider goes on from there, and a layer without a time does not make it forget.
    moves = """<script>
    const key = new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true });
    document.body.dispatchEvent(key);
    document.querySelectorAll('[name="layer"]')[2].click();
    const between = document.getElementById("viewer").dataset;
    document.body.dataset.between = [between.layer, between.frames].join();
    document.querySelectorAll('[name="layer"]')[0].click();
    </script>"""
    seen = shown(page(tmp_path / "rod.html", moves, course), "")
    assert 'data-between="conductivity,1"' in seen.words
    assert (seen.told["layer"], seen.told["frame"], seen.told["time"]) == ("temperature", "5", "50")


def test_what_is_not_known_is_hatched_and_said(tmp_path: Path) -> None:
    low = READER.replace("0.35 * box.height", "0.65 * box.height").split("document.body")[0]
    address = "layer=residual&frame=0&view=0,0,1"
    seen = shown(page(tmp_path / "rod.html", low + "</script>"), address, picture=True)
    assert "Residual under the pointer: not known, at (" in seen.words
    assert "Residual at 0 s: from \u22121.000 K to 1.000 K." in seen.words
    assert seen.picture is not None
    # Seen from where the residual is highest the upper half is red; columns between the dots.
    upper, lower = seen.picture[120:300, 384:394], seen.picture[320:490, 384:394]
    assert (np.ptp(upper, axis=-1) > 40).all() and not (np.ptp(lower, axis=-1) > 10).any()
    # Two greys of the hatching take turns.
    assert lower.std() > 15.0


def test_without_webgl_the_page_says_so_and_tells_its_numbers(tmp_path: Path) -> None:
    seen = shown(page(tmp_path / "rod.html"), "layer=residual&frame=0", "--disable-3d-apis")
    assert "This browser offers no WebGL 2" in seen.words
    assert seen.told["layer"] == "residual" and "triangles" not in seen.told
    assert "Residual at 0 s: from \u22121.000 K to 1.000 K." in seen.words

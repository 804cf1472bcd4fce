"""The viewer's data: what is refused, how values are rounded, and what its page holds."""

from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.report._viewer import MOST_VALUES, Layer, Readings, Viewer
from thermo.report._viewer_data import UNKNOWN, coloured, encode, opening_frame, scale_of
from thermo.report._viewer_page import viewer_page, write_viewer

CORNERS = np.array([[0.0, 0, 0], [0.03, 0, 0], [0, 0.02, 0], [0, 0, 0.01]])
SIDES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
TIME = np.array([0.0, 2.5, 7.0])
WARM = 295.15 + np.outer([1.0, 2.0, 3.0], [0.1, 5.0, 9.0, 2.0])
LEFT = np.array([[0.2, -0.5, 0.1, np.nan], [0.0, 0.1, 0.1, 0.1], [0.3, np.nan, 0.0, -0.1]])
WICKED = "</script><script>alert('1')</script> & <b>"


def warm(name: str = "temperature") -> Layer:
    return Layer(name, "K", TIME, WARM, "temperature")


def viewer(**other: Any) -> Viewer:
    given = {
        "title": "A wedge",
        "vertices": CORNERS,
        "triangles": SIDES,
        "layers": (
            Layer("conductivity", "W/m/K", None, [0.2, 0.3, 4.0, 20.0], "field"),
            Layer("residual", "K", TIME, LEFT, "residual"),
            warm(),
        ),
    }
    return Viewer(**{**given, **other})


def held(page: str) -> dict[str, Any]:
    """The data that the page's program reads."""
    found = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert len(found) == 1
    return json.loads(found[0])


def array(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), kind)


def values(layer: dict[str, Any], vertices: int) -> np.ndarray:
    """What the program makes of the codes of a layer."""
    codes = array(layer["codes"], "<u2").reshape(-1, vertices)
    share, low, high = codes / (UNKNOWN - 1.0), layer["low"], layer["high"]
    found = low * (high / low) ** share if layer.get("log") else low + (high - low) * share
    return np.where(codes == UNKNOWN, np.nan, found)


def test_the_page_holds_what_was_given(tmp_path: Path) -> None:
    readings = Readings(CORNERS[:2] + 0.001, TIME, [[300.0, np.nan]] * 3)
    path = tmp_path / "new" / "wedge.html"
    write_viewer(path, viewer(readings=readings))
    assert list(path.parent.iterdir()) == [path]
    found = held(path.read_text("utf-8"))
    places = array(found["vertices"], "<f4").reshape(-1, 3) + found["centre"]
    np.testing.assert_allclose(places, CORNERS, atol=1e-9)
    np.testing.assert_array_equal(array(found["triangles"], "<u4").reshape(-1, 3), SIDES)
    first, second, third = found["layers"]
    assert [one["name"] for one in found["layers"]] == ["temperature", "residual", "conductivity"]
    assert first["time"] == second["time"] == TIME.tolist() and third["time"] is None
    # Half a step of the range over all times.
    assert np.abs(values(first, 4) - WARM).max() <= 26.9 / 65534 / 2 * 1.001
    np.testing.assert_allclose(values(second, 4), LEFT, atol=1.0 / 65534 / 2 * 1.001)
    assert (second["low"], second["high"]) == (-0.5, 0.5)
    assert third["log"] and not first["log"]
    np.testing.assert_allclose(values(third, 4)[0], [0.2, 0.3, 4.0, 20.0], rtol=4e-5)
    dots = found["readings"]
    np.testing.assert_allclose(
        array(dots["points"], "<f4").reshape(-1, 3) + found["centre"], readings.points, atol=1e-9
    )
    np.testing.assert_allclose(values(dots, 2)[:, 0], 300.0, atol=1e-4)
    assert np.isnan(values(dots, 2)[:, 1]).all()


def test_an_object_far_away_keeps_its_shape() -> None:
    far = CORNERS + np.array([4.5e5, -5.1e6, 300.0])
    found = held(viewer_page(viewer(vertices=far)))
    places = array(found["vertices"], "<f4").reshape(-1, 3)
    np.testing.assert_allclose(places - places[0], CORNERS, atol=1e-8)


@given(
    low=st.floats(-1e4, 1e4),
    wide=st.floats(1e-3, 1e4),
    shares=st.lists(st.floats(0, 1), min_size=1),
)
def test_rounding_is_half_a_step_at_most(low: float, wide: float, shares: list[float]) -> None:
    high = low + wide
    given = np.clip(low + wide * np.array([shares]), low, high)
    back = low + (high - low) * (encode(given, low, high, False) / (UNKNOWN - 1.0))
    assert np.abs(back - given).max() <= (high - low) / 65534 / 2 * 1.0001 + 1e-11


def test_scales_of_the_kinds() -> None:
    assert scale_of(np.array([[290.0, 350.0]]), "temperature") == (290.0, 350.0, False)
    assert scale_of(np.array([[0.2, np.nan, -3.0]]), "residual") == (-3.0, 3.0, False)
    assert scale_of(np.array([[1.0, 10.0]]), "field") == (1.0, 10.0, False)
    assert scale_of(np.array([[1.0, 10.1]]), "field") == (1.0, 10.1, True)
    assert scale_of(np.array([[0.0, 10.1]]), "field") == (0.0, 10.1, False)
    # Temperatures are never logarithmic, not even from 4 K to room temperature.
    assert scale_of(np.array([[4.0, 300.0]]), "temperature") == (4.0, 300.0, False)
    # What is the same everywhere lies in the middle of a range.
    low, high, _ = scale_of(np.array([[293.0, 293.0]]), "temperature")
    assert low < 293.0 < high and low + high == pytest.approx(586.0)
    assert scale_of(np.zeros((1, 2)), "residual") == (-1.0, 1.0, False)


def test_it_opens_where_the_values_differ_most() -> None:
    assert opening_frame(warm()) == 2
    heated = [[293.0] * 4, [293, 300, 310, 305], [293, 310, 300, 305], [320, 325, 320, 320.0]]
    layer = Layer("temperature", "K", np.arange(4.0), heated, "temperature")
    # The first of two alike; not the hottest one, in which the body is nearly as warm all over.
    assert opening_frame(layer) == 1
    others = viewer().layers[1:]
    assert held(viewer_page(viewer(layers=(*others, layer))))["frame"] == 1
    assert held(viewer_page(viewer(layers=others[1:])))["frame"] == 0
    # Of a frame without any value nothing is known.
    gaps = np.array([[np.nan] * 4, [0.0, 0, 0, 0], [np.nan, 0.2, -0.1, np.nan], [0, 0, 0.2, 0]])
    assert opening_frame(Layer("residual", "K", np.arange(4.0), gaps, "residual")) == 2


def test_colours_are_those_of_the_page() -> None:
    maps = held(viewer_page(viewer()))["maps"]
    warmth, sides, span = (array(maps[one], "u1").reshape(-1, 3) for one in maps)
    assert list(maps) == ["temperature", "residual", "field"]
    colours = coloured(warm())
    assert (colours[0, 0] == warmth[0]).all() and (colours[2, 2] == warmth[-1]).all()
    colours = coloured(Layer("residual", "K", TIME[:1], [[-0.5, 0.5, 0.0, np.nan]], "residual"))
    assert (colours[0, :2] == sides[[0, -1]]).all() and (colours[0, 3] == 128).all()
    assert np.ptp(colours[0, 2].astype(int)) < 10  # zero is grey
    # A logarithmic bar: a decade above the lowest of four is a quarter of the way.
    colours = coloured(Layer("conductivity", "W/m/K", None, [0.1, 1.0, 10.0, 1000.0], "field"))
    assert (colours[0] == span[[0, 64, 128, 255]]).all()


class _Texts(HTMLParser):
    """Elements of a page, and the text of its heading and title."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.text = {"title": "", "h1": ""}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        if self.seen and self.seen[-1][0] in self.text:
            self.text[self.seen[-1][0]] += data.strip()


def parsed(page: str) -> _Texts:
    found = _Texts()
    found.feed(page)
    return found


def test_wicked_words_stay_words() -> None:
    layers = (Layer(WICKED, WICKED, None, np.arange(4.0), "field"), warm("t\u2028<!--"))
    page = viewer_page(viewer(title=WICKED, layers=layers))
    found = parsed(page)
    assert [tag for tag, _ in found.seen].count("script") == 3
    assert "b" not in [tag for tag, _ in found.seen]
    assert found.text["h1"] == found.text["title"] == WICKED
    names = [(one["name"], one["unit"]) for one in held(page)["layers"]]
    assert names == [("t\u2028<!--", "K"), (WICKED, WICKED)]


def test_nothing_comes_from_elsewhere_and_controls_have_names() -> None:
    page = viewer_page(viewer())
    found = parsed(page)
    for _, known in found.seen:
        assert "src" not in known and (known.get("href") or "data:").startswith("data:")
    assert "default-src 'none'" in page and "url(" not in page and "import " not in page
    assert ("html", {"lang": "en"}) in found.seen
    tags = [(tag, known.get("aria-label")) for tag, known in found.seen]
    assert ("input", "Time") in tags and all(name for tag, name in tags if tag == "canvas")
    # All others stand in a label.
    loose = [one for tag, one in found.seen if tag == "input" and "aria-label" not in one]
    assert len(loose) == len(re.findall(r"<label[^>]*><input", page))


def test_a_large_object_stays_small() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5)
    time = np.arange(60.0)
    each = np.linspace(290.0, 400.0, 60)[:, None] + np.asarray(ball.vertices)[:, 2]
    layers = (
        Layer("temperature", "K", time, each, "temperature"),
        Layer("residual", "K", time, each - 300.0, "residual"),
        Layer("conductivity", "W/m/K", None, each[0], "field"),
    )
    given = viewer(vertices=ball.vertices, triangles=ball.faces, layers=layers)
    assert len(given.triangles) == 20480
    assert len(viewer_page(given)) < 4_500_000


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"title": " "}, "viewer: title"),
        ({"vertices": CORNERS[:, :2]}, "shape (4, 2)"),
        ({"vertices": CORNERS + [[0, 0, np.inf]]}, "finite metres"),
        ({"vertices": np.vstack([CORNERS, CORNERS[:1]])}, "5, one for each place"),
        ({"triangles": SIDES[:, :2]}, "(triangles, 3)"),
        ({"triangles": SIDES + 1}, "from 1 to 4"),
        ({"triangles": SIDES - 1}, "from -1 to 2"),
        ({"triangles": SIDES.astype(float)}, "float64"),
        ({"triangles": SIDES[:0]}, "no triangles"),
        ({"layers": ()}, "at least one layer"),
        ({"layers": (warm(), warm())}, "of different names"),
    ],
)
def test_a_viewer_that_does_not_fit_is_refused(other: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        viewer(**other)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("", "K", TIME, WARM, "temperature"), "layer: name"),
        (("t", "", TIME, WARM, "field"), "layer t: unit"),
        (("t", "C", TIME, WARM, "temperature"), "temperature in C"),
        (("t", "K", TIME, WARM, "heat"), "heat in K"),
        (("t", "K", TIME[::-1], WARM, "temperature"), "time does not increase"),
        (("t", "K", TIME[:2], WARM, "temperature"), "2 frames, one row each"),
        (("t", "K", None, WARM, "temperature"), "1 frames, one row each"),
        (("t", "K", TIME, WARM[0], "temperature"), "shape (4,)"),
        (("t", "K", TIME, WARM * np.inf, "temperature"), "12 infinite, 0 NaN of 12"),
        (("t", "K", TIME, WARM * np.nan, "temperature"), "0 infinite, 12 NaN of 12"),
        (("t", "K", TIME, [["hot"] * 4] * 3, "temperature"), "layer t: values"),
    ],
)
def test_a_layer_that_does_not_fit_is_refused(given: tuple, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        Layer(*given)


def test_readings_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="4 values a frame"):
        Readings(CORNERS[:2], TIME, WARM)
    with pytest.raises(InputError, match="readings: points"):
        Readings(CORNERS * np.nan, TIME, WARM)


def test_too_many_values_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert MOST_VALUES >= 60 * 10_000 * 3
    monkeypatch.setattr("thermo.report._viewer.MOST_VALUES", 27)
    with pytest.raises(InputError, match="at most 27"):
        viewer()

"""The page of a search for what is missing, and the page in a real browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from thermo.report._discovery_page import discovery_page
from thermo.report._discovery_plots import (
    alias_matrix,
    chance_curve,
    residual_curves,
    residual_maps,
    score_bars,
)

VERDICTS = ("named", "inseparable", "none_of_mine", "no_gap")
MARKUP = "<b onclick='x()'>glow</b> & more"


def candidate(name: str, score: float, left: float | None = None, unit: str = "1") -> dict:
    return {
        "name": name, "score": score, "strength": 0.123456, "sd": 0.0123, "unit": unit,
        "least": None, "most": 0.05 if name == "void" else None,
        "visible": 0.4321, "left": left, "excited_by": "any run",
        "hides_behind": f"what is like {name}", "split_by": f"a run without {name}",
    }  # fmt: skip


def table(*left: float | None) -> list[dict]:
    """Scores over five decades, of which the first are refitted."""
    told = [("hidden_source", 812.0), ("heater_lag", -97.0), (MARKUP, 3.9), ("void", 1e-5)]
    more = [*left, *[None] * (len(told) - len(left))]
    units = ("W", "s", "K", "1")
    each = zip(told, more, units, strict=True)
    return [candidate(name, score, one, unit) for (name, score), one, unit in each]


def found(together: list[str], *, closed: float, place: bool = True) -> dict[str, Any]:
    return {
        "named": together if len(together) == 1 else [], "set": together, "best": together[0],
        "strength": 1.2345, "sd": 0.05, "interval95": [1.1365, 1.3325], "unit": "W",
        "location": {"centre": [0.0123, -0.0045, 0.0], "size": 0.0032} if place else None,
        "part": None, "side": None, "depth": None, "conductance": 0.01234 if place else None,
        "conductance_interval95": [0.0111, 0.0135] if place else None,
        "p_value": 0.0, "gap_closed": closed, "rms_before": {"lamp": 0.7531, "dark": 0.2},
        "rms_after": {"lamp": 0.0521, "dark": 0.05}, "threshold": 4.21,
        "candidates": table(0.0, 0.371),
        "alternatives": {name: lag() for name in together[1:]},
    }  # fmt: skip


def lag() -> dict[str, Any]:
    """What else would explain as much."""
    return {
        "strength": 0.8, "interval95": [0.604, 0.996], "unit": "s", "location": None, "part": None,
        "side": None, "depth": None, "conductance": None, "conductance_interval95": None,
        "rms": {"lamp": 0.0524, "dark": 0.05},
        "parameters": {"conductivity": {"value": 0.3, "interval95": [0.29, 0.31]}},
        "held_out": {"other & all": 0.0654},
    }  # fmt: skip


def squares(changing: float) -> dict[str, Any]:
    """Of a run, what is left in steady shapes, in others and beside them."""
    sizes = {"steady": (20.1, 16), "changing": (changing, 176), "rest": (802.5, 808)}
    return {name: {"squares": one, "expected": count} for name, (one, count) in sizes.items()}


def over_time(score: float, chance: float) -> dict[str, Any]:
    """Of a run, how far what is left follows its lamp."""
    lamp = {"score": score, "lag_s": 1.5, "p_value": chance}
    return {"slow_p_value": 0.37, "follows": {"lamp": lamp}}


def record(verdict: str, **more: Any) -> dict[str, Any]:
    """What `verdict.json` holds, made by hand, as JSON gives it back."""
    rounds = {
        "named": [found(["hidden_source"], closed=0.987)],
        "inseparable": [found(["hidden_source", "heater_lag"], closed=0.987, place=False)],
        "none_of_mine": [found(["hidden_source"], closed=0.34)],
        "no_gap": [],
    }[verdict]
    other = {"rms_before": 0.9, "rms_after": 0.0612, "noise": 0.0498, "gap_closed": 0.981}
    other["gap_closed_interval95"] = [0.961, 0.9997]
    calm = {"rms_before": 0.05, "rms_after": 0.05, "noise": 0.05, "gap_closed": None}
    calm["gap_closed_interval95"] = None
    made = {
        "verdict": verdict, "sentences": [f"It is {verdict}, <i>so</i>.", "On other it falls."],
        "effects": [rounds[0]["best"]] if verdict in ("named", "inseparable") else [],
        "rounds": rounds, "candidates": table(), "threshold": 4.21,
        "alias": {"hidden_source": {"hidden_source": 1.0, "<b>void</b>": 0.37},
                  "<b>void</b>": {"hidden_source": 0.37, "<b>void</b>": 1.0}},
        "held_out": {"other & all": other, "calm": calm},
        "numerics": {"cells_and_steps_K": {"lamp": 0.0071, "dark": 0.0012}},
        "noise": {"lamp": 0.051, "dark": 0.049},
        "parameters": {
            "conductivity": {"before": 0.25, "after": 0.2, "interval95": [0.1913, 0.2091]}
        },
        "p_value": {"without": 0.0, "with": 0.42},
        "could_have_missed": {
            "void": {"strength": None, "unit": "1", "found_in": {"0.5": 0.8, "0.8": None}},
            "heater_lag": {"strength": 0.567, "unit": "s", "found_in": {"0.5": 0.4, "0.8": 0.567}},
        },
        "over_time": {"lamp": {"before": over_time(-17.25, 0.0), "after": over_time(1.31, 0.62)}},
        "gap": {"lamp": {"before": squares(5432.1), "after": squares(201.5)}},
        "residuals": dict.fromkeys(("lamp", "other & all", "calm"), {
            "points": [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.02, 0.0]], "time": [0.0, 1.0],
            "by_sample": {"before": [0.1, 0.9, None], "after": [0.05, 0.06, None]},
            "by_frame": {"before": [0.1, 0.8], "after": [0.05, None]},
        }),
        "calibration": {
            "draws": 200, "false_alarms": {"by_score": 0.041, "by_shapes": 0.01, "either": 0.049},
            "largest_score": {"chance": [0.1, 0.5, 0.96], "value": [1.5, 2.2, 4.2]},
        },
        "remarks": [], "versions": {"python": "3.12.1", "jax": "0.10 <dev>"},
        "seconds": 412.3, "configuration": {"data": "scene"},
    }  # fmt: skip
    return json.loads(json.dumps(made | more))


def shown(page: str) -> str:
    """The page without its scripts, which hold the library that draws."""
    return re.sub(r"<script>.*?</script>|<script type[^>]*>.*?</script>", "", page, flags=re.DOTALL)


class _Checker(HTMLParser):
    """Ids of all elements, texts of cells, and addresses that a browser would fetch."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.fetched: list[str] = []
        self.cells: list[str] = []
        self._tag = ""
        self.feed(shown(page))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._tag = tag
        for name, value in attrs:
            if name == "id" and value:
                self.ids.append(value)
            if name in ("src", "href") and value and not value.startswith("data:"):
                self.fetched.append(value)

    def handle_data(self, data: str) -> None:
        if self._tag == "td":
            self.cells.append(data)


@pytest.mark.parametrize("verdict", VERDICTS)
def test_the_page_is_whole_and_asks_for_nothing(verdict: str) -> None:
    page = discovery_page(record(verdict), "A block <script>")
    checker = _Checker(page)
    assert checker.fetched == [] and "<script src" not in page
    assert 'src="http' not in shown(page) and 'href="http' not in shown(page)
    wanted = ["verdict", "rounds", "gap", "scores", "candidates", "held_out", "parameters",
              "calibration", "missed", "noise", "versions"]  # fmt: skip
    assert [one for one in checker.ids if one in wanted] == wanted
    # Of two runs that were not fitted maps and curves, beside the bars of both.
    drawn = {"scores-0", *(f"held-out-{n}" for n in range(5)), "gap-0", "gap-1", "chance-0"}
    assert drawn <= set(checker.ids) and "held-out-5" not in checker.ids
    assert len(checker.ids) == len(set(checker.ids))
    assert "A block &lt;script&gt;" in page and "0.10 &lt;dev&gt; in 412 s" in page
    assert f'<p class="said lead {verdict}">It is {verdict}, &lt;i&gt;so&lt;/i&gt;.</p>' in page
    assert '<p class="said more">On other it falls.</p>' in page
    assert f"Verdict: <code>{verdict}</code>" in page
    cells = set(checker.cells)
    assert {"0.9", "0.0612", "0.0498", "98.1 % [96.1 %, above 99.9 %]", "nothing to close"} <= cells
    assert {"conductivity", "0.25 W/m/K", "0.2 W/m/K", "-20 %"} <= cells
    assert {"void", "none that can be", "0.8", "0.4 s", "0.567 s"} <= cells
    assert {"changing", "176", "5432", "201.5"} <= cells
    assert {"the lamp", "-17.2 (1.5 s)", "1.3 (1.5 s)", "0.62", "0.37"} <= cells
    assert "4.9 % raise an alarm: 4.1 % by a score and 1.0 % by smooth shapes" in page
    assert {"0.051", "0.0071", "0.049", "0.0012"} <= cells


@pytest.mark.parametrize("verdict", VERDICTS)
def test_markup_in_a_name_is_escaped_in_tables_and_figures(verdict: str) -> None:
    page = discovery_page(record(verdict), "A block")
    assert "<b onclick" not in page and "other & all" not in page
    assert "&lt;b onclick=&#x27;x()&#x27;&gt;glow&lt;/b&gt; &amp; more" in shown(page)
    assert MARKUP in _Checker(page).cells


def test_a_named_effect_is_told_with_its_strength_and_place() -> None:
    page = discovery_page(record("named"), "A block")
    cells = _Checker(page).cells
    row = ["1", "hidden source", "1.234 W", "1.137 to 1.333 W",
           "(12.3, -4.5, 0.0), size 3.2; 0.0123 W/K (0.0111 to 0.0135) in all",
           "below 1e-300", "98.7 %", "lamp: 0.753 to 0.0521; dark: 0.2 to 0.05"]  # fmt: skip
    assert cells[: len(row)] == row
    assert "in few readings. Chance that noise and numerics alone leave so large a misfit" in page
    assert "below 1e-300 before the first round, 0.42 after the last" in page
    assert "0.1913 to 0.2091" in page
    begin = cells.index("+812") - 1
    assert cells[begin : begin + 7] == [
        "hidden source", "+812", "0.123 ± 0.012 W", "43.2 %", "0.0 %", "what is like hidden_source",
        "a run without hidden_source",
    ]  # fmt: skip
    assert cells[begin + 8 : begin + 12] == ["-97", "0.123 ± 0.012 s", "43.2 %", "37.1 %"]
    assert cells[begin + 18] == "not refitted" and cells[begin + 23] == "above 0.05"
    assert page.count('<tr class="named">') == 1 and page.count('<tr class="above">') == 1
    assert "the threshold, 4.21." in page


def test_a_second_round_has_a_row_and_a_sentence_in_large_words() -> None:
    rounds = [found(["hidden_source"], closed=0.9), found(["void"], closed=0.8, place=False)]
    said = ["First.", "Second.", "On other it falls."]
    page = discovery_page(record("named", rounds=rounds, sentences=said), "A block")
    assert page.count('<tr class="round">') == 2 and page.count('class="said lead named"') == 2
    assert "Scores of round 1" in page


def test_a_side_and_a_depth_stand_for_a_place() -> None:
    contact = found(["support_contact"], closed=0.9) | {"side": "+x", "depth": 1.5e-3}
    light = found(["in_depth_absorption"], closed=0.9, place=False) | {"depth": 2e-4}
    grain = found(["anisotropic_conductivity"], closed=0.9, place=False) | {"part": "along z"}
    for one, words in (
        (contact, "side +x, 1.5 deep; 0.0123 W/K"),
        (light, "no place, 0.2 deep"),
        (grain, "along z"),
    ):
        cells = _Checker(discovery_page(record("named", rounds=[one]), "A block")).cells
        assert cells[4].startswith(words)


def test_what_cannot_be_told_apart_stands_together() -> None:
    page = discovery_page(record("inseparable"), "A block")
    words = "hidden source or heater lag: cannot be told apart. The numbers are of hidden source"
    cells = _Checker(page).cells
    assert cells[1] == words and cells[4] == "no place"
    begin = cells.index("heater lag, in its place")
    assert cells[begin + 1 : begin + 4] == ["0.8 s", "0.604 to 0.996 s", "no place"]
    assert "lamp: 0.753 to 0.0524; dark: 0.2 to 0.05" in cells[begin:]
    begin = cells.index("conductivity, with heater lag")
    beside = ["0.25 W/m/K", "0.3 W/m/K", "0.29 to 0.31", "+20 %"]
    assert cells[begin + 1 : begin + 5] == beside
    begin = cells.index("other & all, with heater lag")
    assert cells[begin + 1 : begin + 4] == ["0.9", "0.0654", "0.0498"]
    assert "calm, with heater lag" not in cells
    assert page.count('<tr class="inseparable">') == 2
    closest = found(["hidden_source", "heater_lag"], closed=0.34)
    page = discovery_page(record("none_of_mine", rounds=[closest], effects=[]), "A block")
    assert "conductivity, with heater lag" not in _Checker(page).cells


def test_what_does_not_explain_the_gap_is_not_named() -> None:
    page = discovery_page(record("none_of_mine"), "A block")
    cells = _Checker(page).cells
    assert cells[1] == "hidden source (the closest, not named)" and "34.0 %" in cells
    assert '<tr class="named">' not in page
    # There are intervals of the unknowns only where something is named.
    left_out = "leave out what the shape of a place"
    assert left_out not in page and left_out in discovery_page(record("named"), "A block")
    page = discovery_page(record("none_of_mine", rounds=[]), "A block")
    assert "No candidate was put to work." in page


def test_without_a_gap_there_are_scores_but_no_rounds() -> None:
    chance = {"without": 0.42, "with": 0.42}
    page = discovery_page(record("no_gap", held_out={}, p_value=chance), "A block")
    checker = _Checker(page)
    assert "No candidate was put to work." in page and "smooth shapes: 0.42." in page
    assert "No run was held out" in page and "held-out-0" not in checker.ids
    assert checker.cells.count("not refitted") == 4


def test_a_record_of_nothing_and_of_nulls_is_rendered() -> None:
    nothing = {"candidates": [], "could_have_missed": {}, "parameters": {}}
    page = discovery_page(record("no_gap", **nothing), "A block")
    assert page.count("No candidate could be seen in these runs.") == 2
    assert "No parameter was fitted." in page and "Nothing that was looked for." in page
    one = candidate("void", 5.0) | {"score": None, "strength": None, "sd": None, "unit": "W"}
    bare = record("no_gap", candidates=[one], seconds=None)
    bare["parameters"]["made_up"] = {"before": 0.0, "after": None, "interval95": None}
    cells = _Checker(discovery_page(bare, "A block")).cells
    assert "not known ± not known W" in cells and cells.count("not known") == 3
    assert cells.count("no measurement") == 1


def test_scores_over_more_than_two_decades_have_a_logarithmic_axis() -> None:
    wide: Any = score_bars(table(), 4.21)
    assert wide.layout.xaxis.type == "log" and list(wide.data[0].x) == [812.0, 97.0, 3.9, 0.01]
    assert list(wide.data[0].text) == ["812", "97", "3.9", "1e-05"]
    first, second, third, fourth = wide.data[0].marker.color
    assert first == second != third == fourth
    assert wide.layout.shapes[0].x0 == 4.21 and wide.layout.shapes[0].line.width == 2
    near: Any = score_bars([candidate("void", -2.0), candidate("heater_lag", 9.0)], 4.21)
    assert near.layout.xaxis.type is None and list(near.data[0].y) == ["heater lag", "void"]


def test_the_alias_matrix_shows_each_cosine_where_both_names_meet() -> None:
    found = {
        MARKUP: {MARKUP: 1.0, "heater_lag": 0.25},
        "heater_lag": {MARKUP: 0.5, "heater_lag": 1.0},
    }
    drawn: Any = alias_matrix(found).data[0]
    names = ["&lt;b onclick=&#x27;x()&#x27;&gt;glow&lt;/b&gt; &amp; more", "heater lag"]
    assert list(drawn.x) == names and list(drawn.y) == names
    assert [list(row) for row in drawn.z] == [[1.0, 0.25], [0.5, 1.0]]
    assert [list(row) for row in drawn.text] == [["1.00", "0.25"], ["0.50", "1.00"]]
    assert (drawn.zmin, drawn.zmax) == (0.0, 1.0)


def test_maps_before_and_after_have_one_scale_of_colours() -> None:
    told = record("named")["residuals"]["lamp"]
    figure: Any = residual_maps("<lamp>", told)
    before, after = figure.data
    assert (before.marker.cmin, before.marker.cmax) == (after.marker.cmin, after.marker.cmax)
    assert before.marker.cmax == 0.9 and before.scene != after.scene
    assert "&lt;lamp&gt;" in figure.layout.title.text
    # The third sample has no valid reading, and is not drawn.
    assert list(before.x) == [0.0, 0.01] and list(before.hovertext) == ["0.1 K", "0.9 K"]
    told["by_sample"]["after"] = told["by_frame"]["after"] = None
    bare: Any = residual_curves("lamp", told, None)
    assert len(residual_maps("lamp", told).data) == len(bare.data) == 1 and not bare.layout.shapes


def test_curves_stand_beside_the_noise() -> None:
    figure: Any = residual_curves("lamp", record("named")["residuals"]["lamp"], 0.051)
    assert [one.name for one in figure.data] == ["before", "after"]
    assert [line.y0 for line in figure.layout.shapes] == [0.051]


def test_the_score_that_was_found_is_marked_where_that_leaves_the_curve_to_be_seen() -> None:
    drawn = record("named")["calibration"]["largest_score"]
    for found, marks in ((812.0, [4.2]), (3.9, [4.2, 3.9]), (None, [4.2])):
        figure: Any = chance_curve(drawn, 4.2, found)
        assert [line.x0 for line in figure.layout.shapes] == marks
        assert list(figure.data[0].y) == pytest.approx([0.9, 0.5, 0.04])


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.mark.skipif(BROWSER is None, reason="Chromium is not installed")
@pytest.mark.parametrize("verdict", VERDICTS)
def test_a_browser_draws_the_page_without_errors(verdict: str, tmp_path: Path) -> None:
    path = tmp_path / "verdict.html"
    path.write_text(discovery_page(record(verdict), "A block <script>"), "utf-8")
    flags = (
        "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-quic",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
        "--enable-logging=stderr", "--virtual-time-budget=20000", "--dump-dom",
        f"--user-data-dir={tmp_path}",
    )  # fmt: skip
    page, browser = path.as_uri(), str(BROWSER)
    done = subprocess.run([browser, *flags, page], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    # Chromium logs errors of a page as it logs how fast its own drawing is.
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    slow = ("will-read-frequently", "GL Driver Message")
    assert [line for line in said if not any(word in line for word in slow)] == []
    # Scores and held-out runs in drawings of their own, with the threshold and names as they are.
    drawn = shown(done.stdout)
    assert drawn.count('class="main-svg"') >= 6 and "0.37" in drawn and "stroke-dasharray" in drawn
    assert drawn.count("&lt;b onclick='x()'&gt;glow&lt;/b&gt; &amp; more</text>") == 1
    assert "<b onclick" not in drawn


def test_with_fewer_than_two_candidates_there_is_no_matrix() -> None:
    page = discovery_page(record("no_gap", alias={"void": {"void": 1.0}}), "A body")
    assert "There are no two candidates to compare." in page


@pytest.mark.parametrize(
    ("left", "told"),
    [(1e-7, "0.0 %"), (3e-4, "0.03 %"), (0.0123, "1.2 %"), (0.9995, "above 99.9 %")],
)
def test_a_small_share_is_not_told_as_none(left: float, told: str) -> None:
    one = found(["hidden_source"], closed=0.9) | {"candidates": table(0.0, left)}
    cells = _Checker(discovery_page(record("named", rounds=[one]), "A block")).cells
    begin = cells.index("+812") - 1
    assert cells[begin + 11] == told

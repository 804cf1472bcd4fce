"""The record and the page of an analysis, and the page in a real browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from posteriors import left, smoothness

from thermo.identify import basins, identifiability, profile
from thermo.inverse import Band, Sensitivity
from thermo.observe import Noise, Recording, ResidualNoise, Run
from thermo.report import (
    band_record,
    field_record,
    identifiability_record,
    identifiability_table,
    surface_record,
    write_fields_left,
    write_identifiability,
)

NAMES = ("conductivity", "convection", "emissivity")
FRAMES, SAMPLES = 12, 40
VERDICTS = {"identified", "weak", "not_identified", "at_bound"}


def band() -> Band:
    deviation = np.tile(np.linspace(0.0, 0.2, 5), (4, 1))
    return Band(np.arange(4.0), np.zeros((5, 3)), deviation, 0.94)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An analysis of two unknowns that hide behind each other, and of one that does not."""
    random = np.random.default_rng(0)
    points = random.uniform(-0.01, 0.01, (SAMPLES, 3))
    quiet = 295.0 + 0.05 * random.standard_normal((25, SAMPLES))
    values = np.full((FRAMES, SAMPLES), 300.0)
    record = Recording(points, np.arange(float(FRAMES)), values, quiet=quiet)
    run = Run("lamp", record, 295.0, 295.0, 295.0)
    slopes = random.standard_normal((FRAMES, SAMPLES, 3))
    slopes[..., 2] = slopes[..., 0]
    at = Sensitivity(
        NAMES, {run.name: slopes}, {run.name: 0.05}, staying={run.name: 0.01},
        values=(0.8, 20.0, 0.5),
    )  # fmt: skip
    matrix = slopes.reshape(-1, 3)[:, [1]] / 0.05
    made = profile(lambda u: (matrix @ (u - 3.0), matrix), np.array([3.0]), 0)
    found = identifiability(at)
    whole = slopes.reshape(-1, 3) / 0.05
    ends = basins(lambda u: (whole @ (u - 1.0), whole), np.array([[1.0] * 3, [2.0] * 3]), draws=9)
    data = identifiability_record(found, at, [run], {"convection": made}, ends, ["Bands & more"])
    data["shifts"] = [
        {"name": "convection", "held": "heater_power", "doubt": 0.02, "relative": 0.0488,
         "deviations": 4.0}
    ]  # fmt: skip
    data["next_runs"] = [
        {"name": "hot & bright", "before": 0.2, "weakest": 0.012, "mean": 0.01, "gain": 3.0,
         "pair": None}
    ]  # fmt: skip
    open_, bands = left(smoothness(0.1, prior=2.0)), {"test": band()}
    data |= {"fields": field_record(open_), "surface": surface_record(open_)}
    data["bands"] = band_record(bands)
    out = tmp_path_factory.mktemp("page")
    write_fields_left(out / "fields.npz", open_, bands, draws=3, seed=1)
    write_identifiability(out, data, "A block <script>")
    return out


def test_the_record_keeps_the_contract(folder: Path) -> None:
    record = json.loads((folder / "identifiability.json").read_text())
    assert set(record["parameters"]) == set(NAMES)
    for item in record["parameters"].values():
        assert item["verdict"] in VERDICTS and 0 <= item["informed_by_data"] <= 1
        low, high = item["interval95"]
        assert low <= item["value"] <= high and item["sd"] > 0 and item["unit"]
    (free,) = record["null_directions"]
    assert set(free) == {"combination", "weights"}
    assert free["weights"] == pytest.approx({"conductivity": 1.0, "emissivity": -1.0})
    assert record["parameters"]["convection"]["verdict"] == "identified"
    noise = record["noise"]["lamp"]
    assert noise["white"] == pytest.approx(0.05, rel=0.1) and noise["staying"] == 0.01
    assert noise["source"] == "quiet frames" and "as the noise model" in noise["check"]["words"]
    found = record["parameters"]["convection"]["profile"]
    assert found["kind"] == "bounded" and not found["nonlinear"]
    assert found["lower"] == pytest.approx(found["linear"][0], rel=1e-6)
    assert record["parameters"]["emissivity"]["profile"] is None
    assert sum(item["share"] for item in record["basins"]) == pytest.approx(1.0)
    assert record["basins"][0]["values"]["convection"] == pytest.approx(np.e, rel=1e-3)
    assert record["scatter"]["draws"] == 9 and record["scatter"]["noise_as_foretold"][1]
    assert record["left_out"] == ["Bands & more"]
    assert len(record["maps"]["lamp"]["points"]) == SAMPLES
    assert "jax" in record["versions"]


def test_noise_that_a_fit_showed_is_told_with_where_it_is_from() -> None:
    points = np.random.default_rng(0).random((9, 3))
    record = Recording(points, np.arange(4.0), np.full((4, 9), 300.0))
    run = Run("lamp", record, 300.0, 300.0, 300.0)
    at = Sensitivity(
        ("convection",), {"lamp": np.ones((4, 9, 1))}, {"lamp": 0.1}, staying={"lamp": 0.2},
        values=(10.0,),
    )  # fmt: skip
    asked = (identifiability(at), at, [run], {}, None, [])
    (before,) = identifiability_record(*asked)["noise"].values()
    assert before["from"] == "differences" and before["residual"] is None
    shown = ResidualNoise(Noise(0.07, 0.2, 0.4), 0.3, 0.0, 2e-3)
    (noise,) = identifiability_record(*asked, {"lamp": shown})["noise"].values()
    assert noise["from"] == "residuals" and noise["source"] == "residual of the fit"
    assert (noise["white"], noise["correlation"], noise["offset"]) == (0.07, 0.4, 0.2)
    assert noise["residual"]["apart_m"] == 2e-3 and "2 mm apart" in noise["residual"]["words"]


def test_fields_and_bands_are_kept_with_what_the_maps_show(folder: Path) -> None:
    record = json.loads((folder / "identifiability.json").read_text())
    found, open_ = record["fields"]["convection"], left(smoothness(0.1, prior=2.0))
    assert found["unit"] == "W/m2/K" and found["data_led"] == 16 and found["controls"] == 8
    assert found["deviation"]["median"] == pytest.approx(np.median(open_.deviation("convection")))
    assert found["smoothness"] == [{"step": 0.3, "probability": 1.0}]
    assert set(found["maps"]) == {"value [W/m2/K]", "95 % band [%]", "informed by data"}
    assert all(len(values) == len(open_.mesh.faces) for values in found["maps"].values())
    faces = np.asarray(record["surface"]["faces"])
    assert faces.max() == len(record["surface"]["points"]) - 1
    assert record["bands"]["test"] == {
        "deviation_K": {"p05": 0.0, "median": 0.1, "p95": 0.2, "max": 0.2}, "inside": 0.94
    }  # fmt: skip
    with np.load(folder / "fields.npz", allow_pickle=False) as kept:
        assert kept["conductivity_draws"].shape == (3, len(open_.mesh.faces))
        assert np.array_equal(kept["band_test"], band().deviation)
        assert np.allclose(kept["conductivity_deviation"], open_.deviation("conductivity"))


def test_without_fields_there_is_no_surface() -> None:
    assert field_record(None) == {} and surface_record(None) is None


def test_the_table_names_each_unknown(folder: Path) -> None:
    record = json.loads((folder / "identifiability.json").read_text())
    said = identifiability_table(record)
    assert all(name in said for name in NAMES) and "not_identified" in said


class _Checker(HTMLParser):
    """Ids of all elements, and addresses that a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.fetched: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.ids.append(value)
            if name in ("src", "href") and value and not value.startswith("data:"):
                self.fetched.append(value)


def test_the_page_is_whole_and_asks_for_nothing(folder: Path) -> None:
    page = (folder / "identifiability.html").read_text("utf-8")
    checker = _Checker()
    checker.feed(re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL))
    assert checker.fetched == []
    wanted = {
        "parameters",
        "unknown",
        "noise",
        "directions",
        "profiles",
        "maps",
        "left",
        "versions",
        "fields",
        "bands",
        "next",
    }
    assert wanted <= set(checker.ids) and {
        "maps-0",
        "directions-2",
        "profiles-0",
        "fields-1",
    } <= set(checker.ids)
    assert len(checker.ids) == len(set(checker.ids))
    shown = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "A block &lt;script&gt;" in shown
    assert "+5 %" in shown and "2 %" in shown and "heater_power" in shown
    assert "hot &amp; bright" in shown and "0.012" in shown
    assert "not made" in shown and "Bands &amp; more" in shown


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.mark.skipif(BROWSER is None, reason="Chromium is not installed")
def test_a_browser_draws_the_page_without_errors(folder: Path, tmp_path: Path) -> None:
    flags = (
        "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-quic",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
        "--enable-logging=stderr", "--virtual-time-budget=20000", "--dump-dom",
        f"--user-data-dir={tmp_path}",
    )  # fmt: skip
    page, browser = (folder / "identifiability.html").as_uri(), str(BROWSER)
    done = subprocess.run([browser, *flags, page], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    # Chromium logs errors of a page as it logs how fast its own drawing is.
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    slow = ("will-read-frequently", "GL Driver Message")
    assert [line for line in said if not any(word in line for word in slow)] == []
    # Three figures of directions and one profile as drawings, and one map of points.
    assert done.stdout.count('class="main-svg"') >= 8 and "gl-container" in done.stdout
    assert "<canvas" in done.stdout

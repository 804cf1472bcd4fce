"""`thermo identify` from end to end: before a fit, after one, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from bricks import lay_bricks

from .conftest import Command

MESH = ("mesh=tet4", "mesh.max_nodes=1500", "integrator.tolerance=0.1")
UNKNOWN = "unknown=[conductivity,volumetric_heat_capacity,convection]"


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the fit on bricks stays: no other file's tests may meet it."""
    return tmp_path_factory.mktemp("bricks") / "fit"


@pytest.fixture(autouse=True)
def bricks(monkeypatch: pytest.MonkeyPatch) -> None:
    """What cells make wrong, and so every interval, is of one mesh on all machines."""
    lay_bricks(monkeypatch, (7, 5, 4))


def record(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "identifiability.json").read_text())


def test_before_a_fit_cooling_alone_is_told_to_know_ratios_only(
    command: Command, block: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "before"
    outcome = command(
        "identify", f"data={block}", "runs=[cooling]", UNKNOWN, "initial.conductivity=0.8",
        "candidates={again:{like:cooling},lit:{like:lamp,power:2.0}}", f"out={out}", cache, *MESH,
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    found = record(out)
    assert {item["verdict"] for item in found["parameters"].values()} == {"not_identified"}
    (free,) = found["null_directions"]
    assert "only their ratios are determined" in free["combination"]
    assert "only their ratios are determined" in outcome.out
    # A lamp of known power is what parts them; the same run once more is of no use.
    first, second = found["next_runs"]
    assert (first["name"], second["name"]) == ("lit", "again") and first["pair"] is None
    assert first["weakest"] < 0.1 * first["before"] and second["weakest"] > 0.9 * second["before"]
    assert "lit tells most of the combination that is known least" in outcome.out
    assert found["before_fit"] is True and list(found["noise"]) == ["cooling"]
    assert any("it takes a fit" in line for line in found["left_out"])
    assert (out / "identifiability.html").stat().st_size > 1e6
    assert str(out / "identifiability.html") in outcome.out


def test_after_a_fit_its_runs_unknowns_and_values_are_looked_at(
    command: Command, fit: Path, block: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "after"
    outcome = command(
        "identify", f"data={block}", f"estimate={fit}", f"out={out}", "spread.conductivity=0.5",
        "doubt.heater_power=0.02", "budget=600", "draws=2", "starts=[0.5]", cache, *MESH,
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    found = record(out)
    fitted = json.loads((fit / "result.json").read_text())["fields"]["conductivity"]["median"]
    (item,) = found["parameters"].values()
    assert item["value"] == pytest.approx(fitted) and item["verdict"] == "identified"
    assert set(found["noise"]) == {"lamp", "cooling"}
    assert {one["from"] for one in found["noise"].values()} == {"quiet"}
    assert found["spectrum"]["prior"] == [0.5] and found["before_fit"] is False
    (moved,) = found["shifts"]
    assert moved["held"] == "heater_power" and moved["name"] == "conductivity"
    # A lamp stated too bright makes the body seem to conduct better.
    assert 0.0 < moved["relative"] < 0.2 and moved["deviations"] > 1
    assert item["profile"]["kind"] == "bounded"
    # What cells and steps make wrong was measured, and the interval allows for it.
    assert set(found["defect_K"]) == {"lamp", "cooling"} and found["defect_K"]["lamp"] > 1e-3
    noise_alone = 0.5 / np.sqrt(1 + found["spectrum"]["eigenvalues"][0])
    assert item["relative"] > 1.2 * noise_alone
    # The fit stopped after three steps; the profile goes to the optimum.
    assert found["misfit"] > 2
    assert any("something is missing in the model" in line for line in found["sentences"])
    assert any("outside that interval" in line for line in found["sentences"])
    assert any(
        "2 % too large, heater_power moves conductivity" in one for one in found["sentences"]
    )
    assert [one["share"] for one in found["basins"]] == [1.0]
    assert found["basins"][0]["values"]["conductivity"] == pytest.approx(
        item["profile"]["best"], rel=1e-3
    )
    assert found["scatter"]["optimiser_share"][0] < 0.01
    assert item["profile"]["lower"] < item["profile"]["best"] < item["profile"]["upper"]


def test_a_spent_budget_leaves_the_rest_and_says_so(
    command: Command, fit: Path, block: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "short"
    words = ("identify", f"data={block}", f"estimate={fit}", f"out={out}", cache, *MESH)
    assert command(*words, "budget=1e-6", "starts=[]").code == 0
    found = record(out)
    assert found["parameters"]["conductivity"]["profile"] is None
    assert any("raise budget" in line for line in found["left_out"])
    assert any("no starts" in line for line in found["left_out"])


def test_after_a_fit_of_a_field_its_places_and_predictions_have_bands(
    command: Command, block: Path, cache: str, tmp_path: Path
) -> None:
    fit, out = tmp_path / "fit", tmp_path / "out"
    coarse = (
        "mesh=tet4",
        "mesh.max_nodes=1500",
        "mesh.corrected=false",
        "integrator.tolerance=0.1",
    )
    asked = ("field=patchwise", "field.patches=3", "prior.step=0.2", "optimiser.max_steps=2")
    outcome = command("invert", f"data={block}", f"out={fit}", cache, *coarse, *asked)
    assert outcome.code == 0, outcome.err
    words = ("identify", f"data={block}", f"estimate={fit}", cache, *MESH)
    regions = "regions={end:{centre:[0,0,0],radius:0.01}}"
    outcome = command(*words, f"out={out}", "controls=6", "bands=3", "budget=600", regions)
    assert outcome.code == 0, outcome.err
    found = record(out)
    whole, end = found["means"]
    assert [one["region"] for one in (whole, end)] == ["surface", "end"]
    assert whole["share"] == pytest.approx(1.0) and 0 < end["share"] < 0.5
    for one in (whole, end):
        assert one["profile"]["kind"] == "bounded" and one["unit"] == "W/m/K"
        assert one["profile"]["lower"] < one["profile"]["best"] < one["profile"]["upper"]
    assert 'id="means"' in (out / "identifiability.html").read_text()
    field = found["fields"]["conductivity"]
    assert field["controls"] == 6 and [one["step"] for one in field["smoothness"]] == [0.2]
    assert list(found["bands"]) == ["test_lamp"] and 0 < found["bands"]["test_lamp"]["inside"] <= 1
    assert found["surface"] is not None and (out / "fields.npz").exists()
    # Two steps are too few, and what the fit said of that is said again, before the intervals.
    told = found["sentences"]
    wrong = [line for line in told if "does not explain" in line]
    assert wrong and told[: len(wrong)] == wrong
    told = told[len(wrong) :]
    assert told[0].startswith("The mean of conductivity is") and "From place to place" in told[1]
    assert "Predictions of test_lamp are known to" in told[2]
    assert any("one value each says nothing" in line for line in found["left_out"])
    for odd, parts in (
        ("{surface:{centre:[0,0,0],radius:1}}", ["called surface"]),
        ("{end:{centre:[0,0],radius:1}}", ["regions.end", "centre"]),
        ("{end:{centre:[9,9,9],radius:0.01}}", ["regions.end", "no face"]),
    ):
        outcome = command(*words, f"out={tmp_path / 'odd'}", f"regions={odd}")
        assert outcome.code == 2 and all(part in outcome.err for part in parts), outcome.err
    left = tmp_path / "left"
    assert command(*words, f"out={left}", "controls=0").code == 0
    assert record(left)["fields"] == {}
    assert any("controls is 0" in line for line in record(left)["left_out"])


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["unknown=[heat]"], ["unknown", "heat", "camera_emissivity"]),
        (["unknown=[heater_power]"], ["unknown", "factors alone", "spread"]),
        (["budget=-1"], ["budget", "-1"]),
        (["wanted=0"], ["wanted", "0"]),
        (["budget=long"], ["budget", "long"]),
        (["spread.heat=0.1"], ["heat"]),
        (["spread.convection=0.1"], ["spread.convection", "conductivity"]),
        (["spread.conductivity=-1"], ["spread.conductivity", "-1"]),
        (["field=network"], ["choice"]),
        (["starts=[1,-2]"], ["starts", "-2"]),
        (["starts=3"], ["starts", "[0.3,3]"]),
        (["doubt.conductivity=0.1"], ["doubt.conductivity"]),
        (["draws=-1"], ["draws", "-1"]),
        (["split=[conductivity]"], ["split", "two of"]),
        (["candidates={hot:{like:bath}}"], ["candidates.hot.like", "bath"]),
        (["controls=-1"], ["controls", "-1"]),
        (["bands=few"], ["bands", "few"]),
        (["bands=1"], ["bands", "several draws"]),
        (["regions={end:{centre:[0,0,0],radius:1}}"], ["regions", "a field that was fitted"]),
    ],
)
def test_what_cannot_be_asked_is_refused(
    words: list[str], parts: list[str], command: Command, block: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = command("identify", f"data={block}", f"out={out}", cache, *MESH, *words)
    assert outcome.code == 2 and all(part in outcome.err for part in parts), outcome.err
    assert not out.exists() or list(out.iterdir()) == []


def test_a_fit_of_another_body_is_refused(
    command: Command, fit: Path, own: Path, tmp_path: Path
) -> None:
    surface = own / json.loads((own / "scene.json").read_text())["surface"]
    trimesh.load_mesh(surface).apply_scale([1.0, 1.0, 2.0]).export(surface)
    outcome = command("identify", f"data={own}", f"estimate={fit}", f"out={tmp_path / 'out'}")
    assert outcome.code == 2 and "another body" in outcome.err, outcome.err
    assert "0.016" in outcome.err


@pytest.mark.parametrize("kind", ["missing", "damaged", "other"])
def test_a_folder_without_a_fit_is_refused(
    kind: str, command: Command, block: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "fit"
    folder.mkdir()
    if kind != "missing":
        text = "{" if kind == "damaged" else json.dumps({"verb": "predict"})
        (folder / "result.json").write_text(text)
    outcome = command("identify", f"data={block}", f"estimate={folder}", f"out={tmp_path / 'out'}")
    assert outcome.code == 2 and "no finished fit" in outcome.err, outcome.err
    assert str(folder / "result.json") in outcome.err

"""What a prediction leaves in its folder, and its table."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from thermo.inverse import Prediction, RecoveredField, Scores
from thermo.mesh import box_mesh
from thermo.report import prediction_table, write_predictions

BLOCK = box_mesh((0.04, 0.03, 0.01), (4, 3, 1))
FINER = box_mesh((0.04, 0.03, 0.01), (8, 6, 2))
POINTS = np.array([[x, y, 0.01] for x in (0.01, 0.02, 0.03) for y in (0.01, 0.02)])
TIME = np.arange(5.0)
SCORES = {"spatial": Scores(0.1, 0.2, 0.5), "median": Scores(1.0, 2.0, 3.0)}


def predicted(warmer: float) -> Prediction:
    """Readings that the simulation passes by `warmer` [K]."""
    simulated = 300.0 + np.outer(TIME, np.linspace(1.0, 2.0, len(POINTS)))
    nodal = 300.0 + np.outer(TIME[[0, 2, 4]], 1.0 + FINER.nodes[:, 0])
    return Prediction(
        POINTS, TIME, simulated, simulated - warmer, SCORES, FINER, TIME[[0, 2, 4]], nodal
    )


def page(path: Path) -> dict[str, Any]:
    found = re.findall(r'id="data">(.*?)</script>', path.read_text("utf-8"), re.S)
    return json.loads(found[0])


def test_each_run_leaves_its_files_and_its_page(tmp_path: Path) -> None:
    left = BLOCK.nodes[BLOCK.faces].mean(axis=1)[:, 0] < 0.02
    field = RecoveredField(
        "conductivity", "W/m/K", np.ones(len(BLOCK.cells)), np.where(left, 3.0, 1.0)
    )
    runs = {"lamp": predicted(0.5), "cooling": predicted(-0.25)}
    record = write_predictions(
        tmp_path, "predict", runs, {"note": 1}, 2.5, ["tilt"], ["Mind this."],
        noise={"lamp": 0.05}, mesh=BLOCK, fields={field.name: field},
    )  # fmt: skip
    assert {path.name for path in tmp_path.iterdir()} == {
        "result.json",
        *(f"{start}{run}{end}" for run in runs for start, end in (
            ("", ""), ("", ".npz"), ("", ".pvd"), ("", ".html"), ("curves_", ".png"),
            ("residual_", ".png"),
        )),
    }  # fmt: skip
    assert [path.name for path in sorted((tmp_path / "lamp").iterdir())] == [
        "0000.vtu", "0001.vtu", "0002.vtu",
    ]  # fmt: skip
    for run, off in (("lamp", 0.5), ("cooling", 0.25)):
        shown = page(tmp_path / f"{run}.html")
        assert shown["title"] == f"Prediction of {run}"
        names = [(one["name"], one["unit"]) for one in shown["layers"]]
        assert names == [("temperature", "K"), ("residual", "K"), ("conductivity", "W/m/K")]
        assert shown["layers"][0]["time"] == [0.0, 2.0, 4.0] and shown["frame"] == 2
        # The field of the fit's mesh, which is coarser than the one that is shown.
        ends = shown["layers"][2]["low"], shown["layers"][2]["high"]
        assert ends == pytest.approx((1.0, 3.0))
        assert shown["layers"][1]["high"] == off
        assert len(base64.b64decode(shown["vertices"])) == 12 * len(FINER.surface_nodes)
    assert record == json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert record["scores"]["lamp"]["median"] == {"mae": 1.0, "rmse": 2.0, "max": 3.0}
    assert (record["verb"], record["seconds"], record["effects"]) == ("predict", 2.5, ["tilt"])
    assert record["remarks"] == ["Mind this."] and record["noise"] == {"lamp": 0.05}
    told = prediction_table(record).splitlines()
    assert told[0].endswith("noise [K]  cells [K]")
    # Of the run whose noise is known it stands beside its scores.
    assert [line.split()[-1] for line in told if "median" in line] == ["0.05", "3"]
    assert record["cells"] == {}


def test_what_cells_make_wrong_stands_beside_the_noise(tmp_path: Path) -> None:
    cells = np.array([0.0, 0.0, 0.04, 0.03, 0.0])
    runs = {"lamp": replace(predicted(0.5), cells=cells)}
    record = write_predictions(tmp_path, "predict", runs, {}, 1.0, noise={"lamp": 0.05})
    assert record["cells"]["lamp"] == pytest.approx(
        {"rms": 0.05 / 5**0.5, "largest": 0.04, "time": 2.0}
    )
    assert "0.02236" in prediction_table(record)


def test_a_simulation_has_no_fields(tmp_path: Path) -> None:
    record = write_predictions(tmp_path, "simulate", {"lamp": predicted(0.0)}, {}, 1.0)
    assert [one["name"] for one in page(tmp_path / "lamp.html")["layers"]] == [
        "temperature", "residual",
    ]  # fmt: skip
    assert record["verb"] == "simulate" and record["effects"] == record["remarks"] == []
    table = prediction_table(record)
    assert re.search(r"lamp\s+spatial\s+0\.1\s+0\.2\s+0\.5", table), table

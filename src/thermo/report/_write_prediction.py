"""Everything that a prediction or a simulation leaves in its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from thermo.inverse import Prediction, RecoveredField
from thermo.mesh import Mesh

from ._figure_curves import figure_curves
from ._figure_residuals import figure_residuals
from ._json import write_json
from ._npz import write_npz
from ._table import table
from ._versions import versions
from ._viewer_page import write_viewer
from ._viewer_prediction import viewer_of_prediction
from ._vtk import write_pvd, write_vtu
from ._write_inversion import rms_of


def _write_run(
    folder: Path,
    name: str,
    prediction: Prediction,
    mesh_of_fields: Mesh | None,
    fields: Mapping[str, RecoveredField],
) -> None:
    write_npz(
        folder / f"{name}.npz",
        points=prediction.points,
        time=prediction.time,
        temperature=prediction.temperature,
    )
    mesh = prediction.mesh
    names = []
    (folder / name).mkdir(exist_ok=True)
    for number, temperature in enumerate(prediction.nodal):
        names.append(f"{name}/{number:04d}.vtu")
        point_data = {"temperature": temperature}
        write_vtu(folder / names[-1], mesh.nodes, mesh.cells, point_data=point_data)
    write_pvd(folder / f"{name}.pvd", prediction.nodal_time, names)
    figure_curves(
        folder / f"curves_{name}.png",
        prediction.time,
        prediction.measured,
        prediction.temperature,
        f"Prediction of {name}",
    )
    figure_residuals(
        folder / f"residual_{name}.png",
        prediction.points,
        mesh.nodes,
        mesh.faces,
        rms_of(prediction.temperature, prediction.measured),
        f"Residual of {name}",
    )
    title = f"Prediction of {name}"
    viewer = viewer_of_prediction(title, prediction, mesh=mesh_of_fields, fields=fields)
    write_viewer(folder / f"{name}.html", viewer)


def write_predictions(
    folder: Path | str,
    verb: str,
    predictions: Mapping[str, Prediction],
    configuration: Mapping[str, Any],
    seconds: float,
    effects: Sequence[str] = (),
    remarks: Sequence[str] = (),
    *,
    noise: Mapping[str, float] | None = None,
    mesh: Mesh | None = None,
    fields: Mapping[str, RecoveredField] | None = None,
) -> dict[str, Any]:
    """Write predictions to a folder, `result.json` last, and return that record.

    Leaves for each run `RUN.npz` (points [m], time [s], temperature [K] at the recording's samples
    and frames), `RUN.pvd` with some moments of the whole body for ParaView, `RUN.html`, which shows
    them on the surface with a slider over time, and figures.

    Arguments: `seconds` that the work took [s]; `effects`: names of those beside the stated ones;
    `remarks`: what a reader should know; `noise`: of a reading by run [K]; `mesh` [m] and `fields`
    of the fit [SI], which `RUN.html` shows as well.
    """
    folder = Path(folder)
    for name, prediction in predictions.items():
        _write_run(folder, name, prediction, mesh, fields or {})
    record = {
        "format": "thermofield-result/1",
        "verb": verb,
        "scores": {
            name: {kind: asdict(value) for kind, value in prediction.scores.items()}
            for name, prediction in predictions.items()
        },
        "scores_unit": "K",
        "noise": dict(noise or {}),
        "cells": {
            name: cells_wrong(prediction.time, prediction.cells)
            for name, prediction in predictions.items()
            if prediction.cells is not None
        },
        "effects": list(effects),
        "remarks": list(remarks),
        "seconds": seconds,
        "success": True,
        "versions": versions(),
        "configuration": configuration,
    }
    write_json(folder / "result.json", record)
    return record


def cells_wrong(
    time: Float[np.ndarray, " frames"], cells: Float[np.ndarray, " frames"]
) -> dict[str, float]:
    """What cells make wrong [K]: `rms` over all frames, `largest` in one and the `time` of it [s].

    Arguments: `time` of the frames [s]; `cells`, as a `Prediction` has it [K].
    """
    worst = int(cells.argmax())
    whole = float(np.sqrt((cells**2).mean()))
    return {"rms": whole, "largest": float(cells[worst]), "time": float(time[worst])}


def prediction_table(record: Mapping[str, Any]) -> str:
    """A short table of the scores beside noise and what cells make wrong, for a terminal."""

    def known(run: str) -> list[str]:
        cells = {name: wrong["rms"] for name, wrong in record["cells"].items()}
        told = (which.get(run) for which in (record["noise"], cells))
        return ["" if value is None else f"{value:.4g}" for value in told]

    rows = [
        [run, kind, *(f"{value[key]:.4g}" for key in ("mae", "rmse", "max")), *known(run)]
        for run, kinds in record["scores"].items()
        for kind, value in kinds.items()
    ]
    return table(rows, ["run", "field", "mae [K]", "rmse [K]", "max [K]", "noise [K]", "cells [K]"])

"""Everything that a fit leaves in its folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from thermo.inverse import Estimate, save_estimate, summary, surface_values

from ._figure_curves import figure_curves
from ._figure_field import figure_field
from ._figure_history import figure_history
from ._figure_residuals import figure_residuals
from ._json import write_json
from ._npz import write_npz
from ._table import table
from ._versions import versions
from ._vtk import write_vtu


def inversion_record(
    estimate: Estimate, configuration: Mapping[str, Any], dropped: Mapping[str, int] | None = None
) -> dict[str, Any]:
    """Every number of a fit as plain data: fields [SI], misfits [K], seconds [s]."""
    return {
        "format": "thermofield-result/1",
        "verb": "invert",
        "fields": {name: summary(estimate.mesh, f) for name, f in estimate.fields.items()},
        "fit": {
            "rmse": {name: run.rmse for name, run in estimate.runs.items()},
            "noise": {name: run.noise for name, run in estimate.runs.items()},
            "defect": {name: run.defect for name, run in estimate.runs.items()},
            "deviation": {name: run.deviation for name, run in estimate.runs.items()},
            "final_mae": {name: run.final_mae() for name, run in estimate.runs.items()},
            "rmse_unit": "K",
            "smoothness": estimate.smoothness,
            "frames": {name: len(run.time) for name, run in estimate.runs.items()},
            "dropped": {name: (dropped or {}).get(name, 0) for name in estimate.runs},
            "loss": estimate.history,
            "iterations": [len(stage) for stage in estimate.history],
        },
        **_scale(estimate),
        "mesh": {
            "nodes": len(estimate.mesh.nodes),
            "cells": len(estimate.mesh.cells),
            "order": estimate.order,
            "resolution": estimate.resolution,
        },
        "success": estimate.success,
        "remarks": list(estimate.remarks),
        "seconds": estimate.seconds,
        "versions": versions(),
        "configuration": configuration,
    }


def _scale(estimate: Estimate) -> dict[str, Any]:
    """What the scale of the surface does to the values [1]; nothing where it is exact."""
    effect = estimate.scale
    if effect is None:
        return {}
    return {
        "scale": {
            "relative_deviation": effect.deviation,
            "relative_change_per_scale": effect.change,
            "deviation_without": effect.without,
            "deviation_with": {name: effect.total(name) for name in effect.change},
            "share_of_variance": {name: effect.share(name) for name in effect.change},
        }
    }


def _figures(folder: Path, estimate: Estimate) -> None:
    mesh = estimate.mesh
    for name, field in estimate.fields.items():
        label = f"{name.replace('_', ' ')} [{field.unit}]"
        figure_field(
            folder / f"field_{name}.png", mesh.nodes, mesh.faces, field.faces, "Recovered", label
        )
    for name, run in estimate.runs.items():
        figure_curves(
            folder / f"curves_{name}.png", run.time, run.measured, run.simulated, f"Fit of {name}"
        )
        figure_residuals(
            folder / f"residual_{name}.png",
            run.points,
            mesh.nodes,
            mesh.faces,
            rms_of(run.simulated, run.measured),
            f"Residual of {name}",
        )
    losses = [loss for stage in estimate.history for loss in stage]
    starts = np.cumsum([0, *map(len, estimate.history[:-1])]).tolist()
    figure_history(folder / "history.png", losses, starts)


def rms_of(simulated: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Root mean square residual of each sample over time, (samples,) [K]; NaN without data."""
    square = (simulated - measured) ** 2
    count = np.isfinite(square).sum(0)
    total = np.where(np.isfinite(square), square, 0.0).sum(0)
    return np.where(count > 0, np.sqrt(total / np.maximum(count, 1)), np.nan)


def write_inversion(
    folder: Path | str,
    estimate: Estimate,
    configuration: Mapping[str, Any],
    dropped: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """Write a fit to a folder, `result.json` last, and return that record.

    `dropped`: how many readings of each run were left out as spikes [1].

    Leaves `field.npz` (surface vertices [m] and each field there), `estimate.npz` (what
    `thermo predict` reads), `field.vtu`, figures, and `result.json`.
    """
    folder = Path(folder)
    mesh = estimate.mesh
    arrays: dict[str, np.ndarray] = {}
    for name, field in estimate.fields.items():
        arrays["points"], arrays[name] = surface_values(mesh, field)
    write_npz(folder / "field.npz", **arrays)
    save_estimate(folder / "estimate.npz", estimate)
    owners = {f"{name}_of_face": field.faces for name, field in estimate.fields.items()}
    cells = {name: field.cells for name, field in estimate.fields.items()}
    for name, values in owners.items():
        on_cells = np.full(len(mesh.cells), np.nan)
        on_cells[mesh.owners] = values
        cells[name] = on_cells
    write_vtu(folder / "field.vtu", mesh.nodes, mesh.cells, cell_data=cells)
    _figures(folder, estimate)
    record = inversion_record(estimate, configuration, dropped)
    write_json(folder / "result.json", record)
    return record


def inversion_table(record: Mapping[str, Any]) -> str:
    """A short table of the fields and misfits of a fit, for a terminal.

    Of a field that is the same all over only its value is shown.
    """
    rows = []
    for name, f in record["fields"].items():
        keys = ("p05", "p95") if f["p95"] > f["p05"] * (1 + 1e-9) else ()
        ends = [f"{f[key]:.5g}" for key in keys] or [None, None]
        rows.append([name, f["unit"], f"{f['median']:.5g}", *ends])
    first = table(rows, ["field", "unit", "median", "5 % of the surface", "95 %"])
    fit = record["fit"]
    fits = [
        [name, f"{value:.4g}", f"{fit['noise'][name]:.2g}"] for name, value in fit["rmse"].items()
    ]
    return f"{first}\n\n{table(fits, ['run', 'rmse [K]', 'noise [K]'])}"

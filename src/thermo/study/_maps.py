"""What the figure of recovered fields needs of a case, in one file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float

from thermo.inverse import Estimate, Prediction, RecoveredField, RunFit
from thermo.mesh import face_areas
from thermo.observe import Run, Scene
from thermo.report import write_npz


def error_at_the_end(run: Run, fit: RunFit) -> Float[np.ndarray, " samples"]:
    """Absolute misfit [K] at the last fitted frame, or at the last one with the lamp on.

    Source: paper, figure 2c.
    """
    end = np.inf if run.heater is None else float(run.heater.until)
    frames = np.flatnonzero(fit.time <= end)
    last = frames[-1] if len(frames) else 0
    return np.abs(fit.simulated[last] - fit.measured[last])


def write_maps(
    path: Path,
    scene: Scene,
    estimate: Estimate,
    field: RecoveredField,
    true: float,
    held_out: Mapping[str, Prediction],
) -> None:
    """Write a field over its truth and the errors of temperatures on the surface.

    Leaves `nodes` [m], `faces`, `ratio` (faces,) [1], `areas` [m2], `points` [m] and `fitted`
    (samples,) [K] of the first run, and for each held-out run `points_NAME` [m] and `error_NAME`
    (samples,), its mean absolute error over time [K].
    """
    name, fit = next(iter(estimate.runs.items()))
    arrays = {
        "nodes": estimate.mesh.nodes,
        "faces": estimate.mesh.faces[:, :3],
        "ratio": field.faces / true,
        "areas": face_areas(estimate.mesh),
        "points": fit.points,
        "fitted": error_at_the_end(scene.runs[name], fit),
    }
    for test, prediction in held_out.items():
        arrays[f"points_{test}"] = prediction.points
        arrays[f"error_{test}"] = np.nanmean(
            np.abs(prediction.temperature - prediction.measured), axis=0
        )
    write_npz(path, **arrays)

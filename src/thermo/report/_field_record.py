"""What is left open of fields, as plain data and as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from thermo.inverse import NORMAL, Band, FieldPosterior

from ._npz import write_npz

MOST_FACES = 20_000
"""Faces of a surface [1] up to which the page draws maps: the file stays below some megabytes."""


def field_record(left: FieldPosterior | None) -> dict[str, Any]:
    """By field, how well it is known: deviations of log(phi) [1], lengths [m]; empty without."""
    if left is None:
        return {}
    eigenvalues = left.eigenvalues()
    return {
        name: {
            "unit": field.quantity.unit,
            "controls": len(left.points[name]),
            "smoothness": [
                {"step": one.steps[name], "probability": one.weight} for one in left.mixture
            ],
            "deviation": _quantiles(left.deviation(name)),
            "informed": _quantiles(left.informed(name)),
            "resolution_m": _quantiles(left.resolution(name)),
            "eigenvalues": eigenvalues,
            "data_led": int(np.sum(eigenvalues > 1)),
            "maps": _maps(left, name),
        }
        for name, field in left.fields.items()
    }


def surface_record(left: FieldPosterior | None) -> dict[str, Any] | None:
    """The surface of the maps: `points` [m] and `faces`; None where there are none."""
    if left is None or len(left.mesh.faces) > MOST_FACES:
        return None
    nodes, faces = np.unique(left.mesh.faces[:, :3], return_inverse=True)
    return {"points": np.round(left.mesh.nodes[nodes], 6), "faces": faces.reshape(-1, 3)}


def band_record(made: Mapping[str, Band]) -> dict[str, Any]:
    """By run, standard deviation of a predicted temperature over samples and frames [K]."""
    return {
        name: {"deviation_K": _quantiles(band.deviation), "inside": band.inside}
        for name, band in made.items()
    }


def write_fields_left(
    path: Path, left: FieldPosterior, made: Mapping[str, Band], *, draws: int, seed: int
) -> None:
    """Write maps, draws of the fields [SI] and bands of runs [K] as one NPZ."""
    arrays: dict[str, np.ndarray] = {"nodes": left.mesh.nodes, "faces": left.mesh.faces}
    drawn = left.draw(draws, seed=seed)
    for name, field in left.fields.items():
        arrays[name] = np.asarray(field.face_values())
        arrays[f"{name}_deviation"] = left.deviation(name)
        arrays[f"{name}_informed"] = left.informed(name)
        arrays[f"{name}_draws"] = np.reshape(
            [one[name].faces for one in drawn], (draws, len(left.mesh.faces))
        )
        arrays[f"{name}_points"] = left.points[name]
        arrays[f"{name}_resolution"] = left.resolution(name)
    for name, band in made.items():
        arrays[f"band_{name}_time"], arrays[f"band_{name}_points"] = band.time, band.points
        arrays[f"band_{name}"] = band.deviation
    write_npz(path, **arrays)


def _maps(left: FieldPosterior, name: str) -> dict[str, list[float]] | None:
    if len(left.mesh.faces) > MOST_FACES:
        return None
    shown = {
        f"value [{left.fields[name].quantity.unit}]": np.asarray(left.fields[name].face_values()),
        "95 % band [%]": 100 * np.expm1(NORMAL * left.deviation(name)),
        "informed by data": left.informed(name),
    }
    return {word: [float(f"{one:.4g}") for one in values] for word, values in shown.items()}


def _quantiles(values: np.ndarray) -> dict[str, float]:
    shares = {"p05": 0.05, "median": 0.5, "p95": 0.95, "max": 1.0}
    return {word: float(np.quantile(values, share)) for word, share in shares.items()}

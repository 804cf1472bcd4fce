"""What a fit recovers, and the file that carries it to a prediction."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import final
from zipfile import BadZipFile

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.errors import InputError
from thermo.fields import QUANTITIES, AbstractField, Boundary, TwoMaterialField
from thermo.inverse._properties import Stated
from thermo.inverse._scale_effect import ScaleEffect
from thermo.mesh import Mesh, face_areas, mesh_from_cells
from thermo.observe import write_whole
from thermo.physics.effects import TabulatedLaw

FORMAT = "thermofield-estimate/1"
PARTS = ("points", "heights", "levels")
FAULTS = (OSError, EOFError, KeyError, ValueError, BadZipFile, zlib.error)
LAWS = ("conductivity_law", "capacity_law")
EFFECT = "effect/"
"""Begins the names of arrays of effects."""


@final
@dataclass(frozen=True)
class RecoveredField:
    """A recovered quantity [its SI unit].

    - `name`, `unit`; `cells` (cells,), `faces` (faces,): its values.
    - `boundary`: two materials apart from the mesh, None for other fields.
    """

    name: str
    unit: str
    cells: Float[np.ndarray, " cells"]
    faces: Float[np.ndarray, " faces"]
    boundary: Boundary | None = None


def recovered(found: Mapping[str, AbstractField]) -> dict[str, RecoveredField]:
    """The values of fields [SI], by quantity."""
    fields = {}
    for name, item in found.items():
        cells, faces = (np.asarray(one) for one in _values(item))
        edge = item.boundary() if isinstance(item, TwoMaterialField) else None
        fields[name] = RecoveredField(name, item.quantity.unit, cells, faces, edge)
    return fields


@program
def _values(field: AbstractField) -> tuple[Float[Array, " cells"], Float[Array, " faces"]]:
    return field.cell_values(), field.face_values()


@final
@dataclass(frozen=True)
class RunFit:
    """How one run was fitted.

    - `rmse` [K]; `noise`: of a reading from frame to frame [K].
    - `defect`: root mean square of what was taken off for cells and steps [K], 0 without that.
    - `deviation`: standard deviation that each reading counted with, so that the run weighs as
      much as the independent readings that it holds [K].
    - `time` (frames,) [s]; `points` (samples, 3) [m].
    - `measured`, `simulated` (frames, samples) [K]; a value that was not valid is NaN.
    """

    rmse: float
    noise: float
    defect: float
    deviation: float
    time: Float[np.ndarray, " frames"]
    points: Float[np.ndarray, "samples 3"]
    measured: Float[np.ndarray, "frames samples"]
    simulated: Float[np.ndarray, "frames samples"]

    def final_mae(self) -> float:
        """Mean absolute residual at the last fitted frame that has readings [K]."""
        apart = np.abs(self.simulated - self.measured)
        last = np.flatnonzero(np.isfinite(apart).any(axis=1))[-1]
        return float(np.nanmean(apart[last]))


@final
@dataclass(frozen=True)
class Estimate:
    """The result of a fit. Its `repr` is short: arrays are left out.

    - `mesh`: linear mesh [m] that the fields live on; `order` of the cells that were fitted [1].
    - `stated`: uniform values of everything else [SI]; `fields`: what was recovered, by name.
    - `runs`: how each run was fitted; `history`: loss after each step of each stage [1].
    - `success`; `seconds` [s]; `resolution`: a sentence on how well the skin is resolved.
    - `smoothness`: by field, standard deviation of log(phi) between neighbouring controls [1];
      empty where there are no neighbours.
    - `remarks`: sentences on what a reader of the result should know.
    - `scale`: what a surface whose scale is known roughly does to the values; None where the scale
      is exact, or the parameters too many to tell.
    """

    mesh: Mesh = field(repr=False)
    order: int
    stated: Stated
    fields: dict[str, RecoveredField] = field(repr=False)
    runs: dict[str, RunFit] = field(repr=False)
    history: list[list[float]] = field(repr=False)
    success: bool
    seconds: float
    resolution: str
    smoothness: dict[str, float]
    remarks: tuple[str, ...] = ()
    scale: ScaleEffect | None = None


def weighted_quantile(
    values: Float[np.ndarray, " faces"], areas: Float[np.ndarray, " faces"], share: float
) -> float:
    """Value, in the unit of `values`, below which `share` [1] of the area [m2] lies."""
    order = np.argsort(values)
    total = np.cumsum(areas[order]) - 0.5 * areas[order]
    return float(np.interp(share * areas.sum(), total, values[order]))


def summary(mesh: Mesh, field: RecoveredField) -> dict[str, float | str]:
    """Unit, median, 5 % and 95 % quantile over the surface, by area [m2]; values [SI]."""
    areas = face_areas(mesh)
    return {
        "unit": field.unit,
        "median": weighted_quantile(field.faces, areas, 0.5),
        "p05": weighted_quantile(field.faces, areas, 0.05),
        "p95": weighted_quantile(field.faces, areas, 0.95),
    }


def surface_values(
    mesh: Mesh, field: RecoveredField
) -> tuple[Float[np.ndarray, "vertices 3"], Float[np.ndarray, " vertices"]]:
    """Surface vertices [m] and the field there, the area-weighted mean of the faces around [SI]."""
    nodes, faces = np.unique(mesh.faces[:, :3], return_inverse=True)
    faces = faces.reshape(-1, 3).ravel()
    areas = np.repeat(face_areas(mesh), 3)
    total = np.bincount(faces, areas * np.repeat(field.faces, 3))
    return mesh.nodes[nodes], total / np.bincount(faces, areas)


def save_estimate(
    path: Path, estimate: Estimate, effects: Mapping[str, np.ndarray] | None = None
) -> None:
    """Write mesh [m] and fields [SI] so that `load_estimate` can predict from them.

    The folder is made where it is missing. `effects`: arrays by name of what was added to the
    stated model, for `saved_effects`.
    """
    stated = estimate.stated
    arrays = {
        "format": np.asarray(FORMAT),
        "nodes": estimate.mesh.nodes,
        "cells": estimate.mesh.cells,
        "faces": estimate.mesh.faces,
        "order": np.asarray(estimate.order),
        "stated": np.array(
            [stated.conductivity, stated.capacity, stated.convection, stated.emissivity]
        ),
    }
    for name in LAWS:
        law = getattr(stated, name)
        if law is not None:
            arrays[name] = np.stack([law.temperature, law.value])
    for name, found in estimate.fields.items():
        arrays[f"cells_{name}"], arrays[f"faces_{name}"] = found.cells, found.faces
        if found.boundary is not None:
            for part in PARTS:
                arrays[f"{part}_{name}"] = getattr(found.boundary, part)
    arrays |= {EFFECT + name: array for name, array in (effects or {}).items()}
    with write_whole(path) as temporary:
        np.savez_compressed(temporary, allow_pickle=False, **arrays)


def _read(path: Path) -> dict[str, np.ndarray]:
    with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
        arrays = dict(stored)
    if str(arrays["format"]) != FORMAT:
        raise KeyError(str(arrays["format"]))
    return arrays


def _law(arrays: Mapping[str, np.ndarray], name: str) -> TabulatedLaw | None:
    return TabulatedLaw(*map(jnp.asarray, arrays[name])) if name in arrays else None


def _damaged(path: Path, fault: Exception) -> InputError:
    missing = isinstance(fault, FileNotFoundError)
    return InputError(
        "this estimate cannot be read",
        where=str(path),
        value="no such file" if missing else f"{type(fault).__name__}: {fault}",
        limit=f"a file of format {FORMAT} that `thermo invert` or `thermo discover` wrote",
        remedy="give the `out` folder of a finished `thermo invert` or `thermo discover`",
    )


def saved_effects(path: Path) -> dict[str, np.ndarray]:
    """What was added to the stated model as arrays by name, places [m] among them, or none.

    Raises `InputError` where the file is missing, damaged or of another format.
    """
    try:
        arrays = _read(path)
    except FAULTS as fault:
        raise _damaged(path, fault) from fault
    begin = len(EFFECT)
    return {name[begin:]: array for name, array in arrays.items() if name.startswith(EFFECT)}


def load_estimate(path: Path) -> tuple[Mesh, int, Stated, dict[str, RecoveredField]]:
    """Read the mesh [m], its order [1], stated values and fields [SI] of an estimate.

    Raises `InputError` where the file is missing, damaged or of another format.
    """
    try:
        arrays = _read(path)
        mesh = mesh_from_cells(arrays["nodes"], arrays["cells"], where=str(path))
        if not np.array_equal(mesh.faces, arrays["faces"]):
            raise ValueError("the faces are in another order")
        fields = {
            name: RecoveredField(
                name,
                quantity.unit,
                arrays[f"cells_{name}"],
                arrays[f"faces_{name}"],
                Boundary(*(arrays[f"{part}_{name}"] for part in PARTS))
                if f"{PARTS[0]}_{name}" in arrays
                else None,
            )
            for name, quantity in QUANTITIES.items()
            if f"cells_{name}" in arrays
        }
        stated = replace(
            Stated(*arrays["stated"].astype(float).tolist()),
            **{name: _law(arrays, name) for name in LAWS},
        )
        return mesh, int(arrays["order"]), stated, fields
    except FAULTS as fault:
        raise _damaged(path, fault) from fault

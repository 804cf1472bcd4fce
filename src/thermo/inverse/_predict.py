"""Temperatures under conditions that were not fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, final

import numpy as np

from thermo._compiled import make_room
from thermo._say import Say
from thermo.errors import InputError
from thermo.inverse._addition import Addition
from thermo.inverse._body import (
    Meshing,
    check_values,
    sizing_of,
    state,
    surface_of,
)
from thermo.inverse._estimate import Estimate, RecoveredField, load_estimate, saved_effects
from thermo.inverse._forward import Prediction, forward
from thermo.inverse._inner_edges import mesh_to_measure
from thermo.inverse._properties import (
    Stated,
    Values,
    check_unknowns,
    diffusivity_quantile,
    properties,
)
from thermo.inverse._selection import select_runs
from thermo.inverse._side_by_side import at_once
from thermo.inverse._stepping import free_grid
from thermo.inverse._transfer import carry_over, check_same_object, medians
from thermo.mesh import Mesh, Surface, expected_nodes
from thermo.observe import Run, Scene, read_scene

PREDICTION_NODES = 40000
"""About the most nodes [1] of a mesh that predicts: it is used once, a fit's some hundred times."""

FINER: Final = (2.0, 1.6, 1.25)
"""By what edges are divided beside those that physics asks for, the first that nodes allow [1]."""

COARSER: Final = 2.0
"""How much longer edges are on the mesh that tells what cells make wrong [1]."""


def _load(folder: Path) -> tuple[Mesh, Stated, dict[str, RecoveredField]]:
    if (folder / "checkpoint.npz").exists() and not (folder / "estimate.npz").exists():
        raise InputError(
            "this fit was interrupted",
            where=str(folder),
            value="checkpoint.npz and no estimate.npz",
            limit="the folder of a finished fit",
            remedy="give the same `thermo invert` command again: it goes on",
        )
    mesh, _, stated, fields = load_estimate(folder / "estimate.npz")
    return mesh, stated, fields


def _parts(
    estimate: Estimate | str | Path, additions: tuple[Addition, ...] | None
) -> tuple[str, Mesh, Stated, dict[str, RecoveredField]]:
    if isinstance(estimate, Estimate):
        return "estimate", estimate.mesh, estimate.stated, estimate.fields
    parts = _load(Path(estimate))
    _check_additions(Path(estimate) / "estimate.npz", additions)
    return str(estimate), *parts


def _check_additions(path: Path, additions: tuple[Addition, ...] | None) -> None:
    names = sorted({name.split("/")[1] for name in saved_effects(path)})
    if names and additions is None:
        raise InputError(
            "this fit holds effects beyond what the scene states",
            where=str(path),
            value=", ".join(names),
            limit="a prediction with them, or knowingly without",
            remedy="give additions=thermo.discover.load_effects(folder, data), or additions=()",
        )


def predict(
    data: Scene | str | Path,
    estimate: Estimate | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    meshing: Meshing | None = None,
    tolerance: float = 5e-3,
    additions: tuple[Addition, ...] | None = None,
    say: Say = lambda words: None,
) -> dict[str, Prediction]:
    """Predict runs with recovered fields, without fitting anything to them.

    Arguments:

    - `data`: a scene, or the folder of one.
    - `estimate`: the result of `invert`, or the folder that `thermo invert` left.
    - `runs`: names; all that are held out by default.
    - `meshing`: of the body; edges are up to half as long as it asks for, as far as its nodes
      allow, by default more than a fit's. Cells and faces take the values of the nearest ones of
      the fit, and two materials are laid out anew. `tolerance`: error of a time step [K].
    - `additions`: effects beside the stated ones, as `thermo.discover.load_effects` reads them.
    - `say`: told what is being done.

    Returns a prediction for each run, with scores of the spatial field and of its median over the
    surface [K], and what its cells make wrong: a third of how far readings are from those on edges
    twice as long, as for errors of second order. Raises `InputError` for unknown runs, for an
    estimate that cannot be read, for one of another object, and for one to which effects were added
    where no `additions` are given.

    Source: paper, section 5 (checklist G10 to G17).
    """
    make_room()
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    picked = select_runs(scene, runs, held_out=True)
    where, old, stated, fields = _parts(estimate, additions)
    meshing = Meshing(max_nodes=PREDICTION_NODES) if meshing is None else meshing
    surface = surface_of(scene)
    check_same_object(old, surface, where)
    say(f"predicting {', '.join(run.name for run in picked)}: meshing and compiling come first")
    # Heat goes the least deep where the diffusivity is least; the mesh must show that.
    found = {name: (item.cells, item.faces) for name, item in fields.items()}
    least = diffusivity_quantile(stated, found, len(old.cells), 0.05)
    finer = _affordable(scene, surface, least, meshing)
    asked = _Asked(scene.folder, stated, meshing.order, tolerance, additions or ())

    def on_edges(by: float) -> list[Prediction]:
        mesh = mesh_to_measure(scene, surface, least, meshing, finer=by)
        carried = {"spatial": carry_over(fields, old, mesh)}
        if by == finer:
            carried["median"] = medians(fields, old, mesh)
        return [asked.predicted(run, mesh, carried) for run in picked]

    best, rough = at_once(on_edges, (finer, finer / COARSER))
    pairs = zip(picked, best, rough, strict=True)
    return {run.name: _told_apart(better, worse) for run, better, worse in pairs}


def _told_apart(best: Prediction, rough: Prediction) -> Prediction:
    """With about what its cells make wrong [K], from one on edges twice as long."""
    apart = (best.temperature - rough.temperature) / (COARSER**2 - 1.0)
    return replace(best, cells=np.sqrt((apart**2).mean(axis=1)))


@final
@dataclass(frozen=True)
class _Asked:
    """What a prediction of a run takes beside its mesh and fields."""

    folder: Path
    stated: Stated
    order: int
    tolerance: float
    additions: tuple[Addition, ...]

    def predicted(
        self, run: Run, mesh: Mesh, carried: Mapping[str, Mapping[str, Values]]
    ) -> Prediction:
        sizes = (len(mesh.cells), len(mesh.faces))
        bodies = {name: properties(self.stated, held, *sizes) for name, held in carried.items()}
        steps = free_grid(mesh, bodies["spatial"], run, tolerance=self.tolerance)
        where = f"{self.folder}: runs.{run.name}.recording"
        return forward(mesh, self.order, run, bodies, steps, where, self.additions)


def _affordable(scene: Scene, surface: Surface, diffusivity: float, meshing: Meshing) -> float:
    """By what all edges of the mesh can be divided within its nodes [1]: one of `FINER`, or 1."""
    sizing = sizing_of(scene, surface, diffusivity, meshing)
    fits = (by for by in FINER if expected_nodes(surface, sizing.divided(by)) <= meshing.max_nodes)
    return next(fits, 1.0)


def simulate(
    data: Scene | str | Path,
    run: str,
    *,
    values: dict[str, float] | None = None,
    meshing: Meshing | None = None,
    tolerance: float = 5e-3,
    say: Say = lambda words: None,
) -> Prediction:
    """Simulate a run of a scene with uniform values.

    Arguments:

    - `data`: a scene, or the folder of one; `run`: the name of its run.
    - `values`: by quantity, in place of what the scene states [SI].
    - `meshing`: of the body; `tolerance`: error of a time step [K].
    - `say`: told what is being done.

    Returns temperatures and scores [K], and what cells make wrong, as `predict` does. Raises
    `InputError` where a property has no value, and as `read_scene` does.
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    (picked,) = select_runs(scene, (run,), held_out=True)
    values = {} if values is None else values
    check_values(values, where="values.")
    meshing = Meshing() if meshing is None else meshing
    if scene.material.conductivity is None and not {"conductivity", "diffusivity"} & set(values):
        raise InputError(
            "the conductivity has no value",
            where=f"{scene.folder}/scene.json: material.conductivity",
            value="null",
            limit="a positive number [W/m/K]",
            remedy="give material.conductivity=0.2, for example",
        )
    check_unknowns(tuple(values), scene)
    stated = state(scene, values, 1.0)
    surface, where = surface_of(scene), f"{scene.folder}: runs.{run}.recording"
    say(f"simulating {run}: meshing and compiling come first")

    def made(finer: float) -> Prediction:
        mesh = mesh_to_measure(scene, surface, stated.of("diffusivity"), meshing, finer=finer)
        body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
        steps = free_grid(mesh, body, picked, tolerance=tolerance)
        return forward(mesh, meshing.order, picked, {"stated": body}, steps, where)

    return _told_apart(*at_once(made, (1.0, 1.0 / COARSER)))

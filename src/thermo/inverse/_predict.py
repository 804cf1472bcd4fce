"""Temperatures under conditions that were not fitted."""

from __future__ import annotations

from pathlib import Path

from thermo._compiled import make_room
from thermo.errors import InputError
from thermo.inverse._addition import Addition
from thermo.inverse._body import Meshing, check_values, make_mesh, state, surface_of
from thermo.inverse._estimate import Estimate, RecoveredField, load_estimate, saved_effects
from thermo.inverse._forward import Prediction, forward
from thermo.inverse._properties import (
    Stated,
    check_unknowns,
    diffusivity_quantile,
    properties,
)
from thermo.inverse._selection import select_runs
from thermo.inverse._stepping import free_grid
from thermo.inverse._transfer import carry_over, check_same_object, medians
from thermo.mesh import Mesh
from thermo.observe import Scene, read_scene

PREDICTION_NODES = 40000
"""About the most nodes [1] of a mesh that predicts: it is used once, a fit's some hundred times."""


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
) -> dict[str, Prediction]:
    """Predict runs with recovered fields, without fitting anything to them.

    Arguments:

    - `data`: a scene, or the folder of one.
    - `estimate`: the result of `invert`, or the folder that `thermo invert` left.
    - `runs`: names; all that are held out by default.
    - `meshing`: of the body, by default finer than a fit's: cells and faces take the values of the
      nearest ones of the fit, and two materials are laid out anew. `tolerance`: error of a time
      step [K].
    - `additions`: effects beside the stated ones, as `thermo.discover.load_effects` reads them.

    Returns a prediction for each run, with scores of the spatial field and of its median over the
    surface [K]. Raises `InputError` for unknown runs, for an estimate that cannot be read, for one
    of another object, and for one to which effects were added where no `additions` are given.

    Source: paper, section 5 (checklist G10 to G17).
    """
    make_room()
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    picked = select_runs(scene, runs, held_out=True)
    where, old, stated, fields = _parts(estimate, additions)
    meshing = Meshing(max_nodes=PREDICTION_NODES) if meshing is None else meshing
    surface = surface_of(scene)
    check_same_object(old, surface, where)
    # Heat goes the least deep where the diffusivity is least; the mesh must show that.
    found = {name: (item.cells, item.faces) for name, item in fields.items()}
    least = diffusivity_quantile(stated, found, len(old.cells), 0.05)
    mesh = make_mesh(scene, surface, least, meshing)
    sizes = (len(mesh.cells), len(mesh.faces))
    bodies = {
        "spatial": properties(stated, carry_over(fields, old, mesh), *sizes),
        "median": properties(stated, medians(fields, old, mesh), *sizes),
    }
    order = meshing.order
    return {
        run.name: forward(
            mesh,
            order,
            run,
            bodies,
            free_grid(mesh, bodies["spatial"], run, tolerance=tolerance),
            f"{scene.folder}: runs.{run.name}.recording",
            additions or (),
        )  # fmt: skip
        for run in picked
    }


def simulate(
    data: Scene | str | Path,
    run: str,
    *,
    values: dict[str, float] | None = None,
    meshing: Meshing | None = None,
    tolerance: float = 5e-3,
) -> Prediction:
    """Simulate a run of a scene with uniform values.

    Arguments:

    - `data`: a scene, or the folder of one; `run`: the name of its run.
    - `values`: by quantity, in place of what the scene states [SI].
    - `meshing`: of the body; `tolerance`: error of a time step [K].

    Raises `InputError` where a property has no value, and as `read_scene` does.
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    (picked,) = select_runs(scene, (run,), held_out=False)
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
    mesh = make_mesh(scene, surface_of(scene), stated.of("diffusivity"), meshing)
    body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
    where = f"{scene.folder}: runs.{run}.recording"
    steps = free_grid(mesh, body, picked, tolerance=tolerance)
    return forward(mesh, meshing.order, picked, {"stated": body}, steps, where)

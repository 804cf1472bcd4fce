"""A fit as it was asked for, and what it needs before it begins."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np

from thermo.errors import InputError
from thermo.fields import QUANTITIES, AbstractField
from thermo.inverse._body import (
    Meshing,
    check_values,
    make_mesh,
    scan_conductivity,
    state,
    surface_of,
)
from thermo.inverse._field_choice import AbstractFieldChoice
from thermo.inverse._inner_edges import mesh_to_measure
from thermo.inverse._objective import FieldPrior
from thermo.inverse._optimiser import AbstractOptimiser
from thermo.inverse._properties import Stated, check_unknowns
from thermo.inverse._selection import select_fit_runs, select_unknowns
from thermo.inverse._smoothing import WEAK_STEP
from thermo.inverse._stepping import Stepping, fit_frames, planned_steps
from thermo.mesh import Fine, Mesh
from thermo.observe import Run, Scene, read_scene
from thermo.physics import TimeGrid

FINER: Final = 2.0
"""Edges and surface tolerance of a fit's mesh over those of one that it is measured against [1]."""


@final
@dataclass(frozen=True)
class Prior:
    """What is believed before the data.

    - `step`: standard deviation of log(phi) between neighbouring controls [1]; small is smooth.
      None lets the data choose, for fields on control points and patches and optimisers that
      stop by themselves; it is 0.3 for others.
    - `spread`: by quantity, the standard deviation of log(phi) about its initial value [1];
      quantities that the scene's own prior names take it from there.
    - `decay`: weight of the squared parameters [1].
    """

    step: float | None = None
    spread: dict[str, float] = field(default_factory=dict)
    decay: float = 0.0


def _priors(
    fields: dict[str, AbstractField],
    pairs: dict[str, np.ndarray],
    stated: Stated,
    scene: Scene,
    prior: Prior,
) -> dict[str, FieldPrior]:
    spread = {**scene.prior, **prior.spread}
    return {
        name: FieldPrior(
            pairs=pairs[name],
            step=jnp.asarray(WEAK_STEP if prior.step is None else prior.step),
            centre=jnp.asarray(stated.of(name)),
            spread=jnp.asarray(spread.get(name, np.inf)),
            decay=jnp.asarray(prior.decay),
        )
        for name in fields
    }


@final
@dataclass(frozen=True)
class Task:
    """Everything that was asked of a fit."""

    scene: Scene
    runs: tuple[Run, ...]
    names: tuple[str, ...]
    choice: AbstractFieldChoice
    optimiser: AbstractOptimiser
    prior: Prior
    stepping: Stepping
    meshing: Meshing
    stages: str
    initial: dict[str, float]
    seed: int
    model_error: float
    start: float = 1.0

    def key(self) -> str:
        """A hash that another fit does not share."""
        # How long to go on is not part of the question.
        method = replace(self.optimiser, max_steps=1)
        asked = (self.names, self.choice, method, self.prior, self.stepping)
        where = (replace(self.meshing, cache=None), self.stages, sorted(self.initial.items()))
        scene = self.scene
        body = (scene.material, scene.convection, scene.emissivity, scene.unit, scene.prior)
        numbers = (self.seed, self.model_error, self.start)
        digest = hashlib.sha256(repr((asked, where, body, *numbers)).encode())
        digest.update(scene.surface_path.read_bytes())
        for run in self.runs:
            around = (run.initial_temperature, run.ambient_temperature, run.radiation_temperature)
            # A module's text leaves out what its arrays hold.
            held = (run.recording, run.heater, run.prescribed, run.insulated, run.air)
            leaves = [np.ascontiguousarray(leaf) for leaf in jax.tree.leaves(held)]
            shapes = [leaf.shape for leaf in leaves]
            errors = (run.constant_error, run.noise)
            layout = (run.name, around, errors, str(jax.tree.structure(held)), shapes)
            digest.update(repr(layout).encode())
            for leaf in leaves:
                digest.update(leaf.tobytes())
        return digest.hexdigest()[:16]


@final
@dataclass(frozen=True)
class Ready:
    """The body of a fit: mesh, stated values, fields with their priors.

    Of each run: `grids`, the frames that are fitted, and `steps`, unless frames give them.
    """

    mesh: Mesh
    stated: Stated
    fields: dict[str, AbstractField]
    priors: dict[str, FieldPrior]
    grids: dict[str, TimeGrid]
    steps: dict[str, TimeGrid | None]


def what_is_asked(
    data: Scene | str | Path,
    runs: tuple[str, ...] | None,
    unknown: tuple[str, ...] | None,
    initial: dict[str, float] | None,
) -> tuple[Scene, tuple[Run, ...], tuple[str, ...], dict[str, float]]:
    """The scene, runs, unknowns and first values [SI] of a fit, checked before any work.

    Arguments as for `invert`. Raises `InputError` as it does.
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    names = select_unknowns(scene, unknown)
    initial = {} if initial is None else initial
    check_unknowns(names, scene, initial)
    check_values(initial, names)
    _check_first(names, scene, initial)
    return scene, tuple(select_fit_runs(scene, runs)), names, initial


def _check_first(names: tuple[str, ...], scene: Scene, initial: Mapping[str, float]) -> None:
    """Refuse to begin at nothing, which no factor changes. Raises `InputError`."""
    for name, value, guess in (
        ("convection", scene.convection, "10"), ("emissivity", scene.emissivity, "0.8"),
    ):  # fmt: skip
        alike = {name, f"scaled_{name}"}
        begins = value != 0.0 or any(initial.get(one, 0.0) > 0.0 for one in alike)
        if alike & set(names) and not begins:
            raise InputError(
                f"{name} is looked for by factors of a first value that is nothing",
                where=f"{scene.folder}/scene.json: surface_exchange.{name}", value=0,
                limit="a first value above 0, or null",
                remedy="state a rough guess or null there, "
                f"give initial.{name}={guess}, or leave it out of unknown=[...]",
            )  # fmt: skip


def prepare(task: Task) -> Ready:
    """Mesh the body [m], lay out its fields and plan the steps of each run [s]."""
    stated = stand_in(task)
    return lay_out(task, mesh_for(task, stated), stated)


def stand_in(task: Task) -> Stated:
    """What is stated, and what stands in for what is not [SI]."""
    scene, initial, guess = task.scene, task.initial, 1.0
    if scene.material.conductivity is None and not {"conductivity", "diffusivity"} & set(initial):
        guess = scan_conductivity(scene, surface_of(scene), list(task.runs), task.meshing)
    return state(scene, initial, guess)


def mesh_for(task: Task, stated: Stated, finer: float = 1.0, fine: tuple[Fine, ...] = ()) -> Mesh:
    """The mesh of a fit [m], or one whose lengths are divided by `finer` [1].

    `fine`: where they are shorter still; so they are at inner edges of a mesh that is measured on.
    """
    made = make_mesh if finer < FINER else mesh_to_measure
    body = task.scene, surface_of(task.scene), stated.of("diffusivity")
    return made(*body, task.meshing, finer=finer, fine=fine)


def lay_out(task: Task, mesh: Mesh, stated: Stated) -> Ready:
    """Fields, frames and steps of a fit on a mesh [m] that is there, with `stated` values [SI]."""
    fields, pairs = {}, {}
    for number, name in enumerate(task.names):
        first = task.start * stated.of(name)
        made = task.choice.make(QUANTITIES[name], mesh, first, task.seed + number)
        fields[name], pairs[name] = made
    priors = _priors(fields, pairs, stated, task.scene, task.prior)
    grids = {run.name: fit_frames(run, task.stepping) for run in task.runs}
    steps = {run.name: planned_steps(mesh, stated, run, task.stepping) for run in task.runs}
    return Ready(mesh, stated, fields, priors, grids, steps)

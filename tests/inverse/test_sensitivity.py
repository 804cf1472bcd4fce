"""Slopes of recorded temperatures, against differences of simulations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import (
    Adam,
    Meshing,
    Network,
    Patchwise,
    Prior,
    Sensitivity,
    Stepping,
    Uniform,
    sensitivity,
)
from thermo.inverse import _sensitivity as module
from thermo.inverse._case import in_kelvin
from thermo.inverse._objective import residual, start
from thermo.inverse._stages import make_objective
from thermo.inverse._task import Task, prepare
from thermo.observe import Scene

pytestmark = pytest.mark.usefixtures("bricks")

VALUE = 0.8
RUNS = ("lamp", "cooling")


# At the usual tolerance the solver's own error, over the width of a difference, is seen.
STEPPING, INITIAL = Stepping(tolerance=0.02, rtol=1e-8), {"conductivity": VALUE}


@pytest.fixture(scope="module")
def found(scene: Scene, meshing: Meshing) -> Sensitivity:
    """Slopes by the conductivity of the whole and by both factors."""
    return sensitivity(
        scene, runs=RUNS, initial=INITIAL, meshing=meshing, stepping=STEPPING,
        scales=("heater_power", "camera_emissivity"),
    )  # fmt: skip


def test_slopes_are_differences_of_simulations(
    found: Sensitivity, scene: Scene, meshing: Meshing
) -> None:
    assert found.names == ("conductivity", "heater_power", "camera_emissivity")
    assert found.values == pytest.approx((VALUE, 1.0, 1.0))
    picked = tuple(scene.runs[name] for name in RUNS)
    how = (Uniform(), Adam(), Prior(), STEPPING, meshing, "none", INITIAL, 0, 0.0)
    task = Task(scene, picked, ("conductivity",), *how)
    # On one mesh: simulations of their own would each be meshed for their own diffusivity.
    made = make_objective(task, prepare(task), meshing.order)
    objective = replace(made, cases=tuple(in_kelvin(case) for case in made.cases))
    (group,) = objective.cases

    @eqx.filter_jit
    def at(raw: jax.Array, power: jax.Array) -> tuple[jax.Array, jax.Array]:
        field = objective.fields["conductivity"].with_parameters(raw)
        dimmed = eqx.tree_at(lambda one: one.under.power, group, group.under.power * power)
        changed = replace(objective, cases=(dimmed,))
        value = residual(changed, {"conductivity": raw})[: group.data.size]
        return value.reshape(group.data.shape), jnp.log(field.control_values())

    (raw,), one, shift = start(objective).values(), jnp.ones(()), 1e-3
    (more, above), (less, below) = at(raw + shift, one), at(raw - shift, one)
    (bright, _), (dim, _), (here, _) = at(raw, one + shift), at(raw, one - shift), at(raw, one)
    # What is read above the temperature that the body reflects.
    over = (here + group.data - group.under.surroundings[:, None, None]) * group.used
    columns = [(more - less) / (above - below)[0], (bright - dim) / (2 * shift), over]
    wanted = np.stack([np.asarray(column) for column in columns], -1)
    for number, name in enumerate(RUNS):
        slope, mine = found.slopes[name], wanted[objective.sequence.index(number)]
        apart = np.abs(slope - mine[:, : slope.shape[1]]).max((0, 1))
        assert np.all(apart <= 1e-5 * np.abs(slope).max((0, 1)))
    assert not np.any(found.slopes["cooling"][..., 1]), "a lamp that is off has no power"


def test_a_factor_that_is_not_known_is_refused(scene: Scene) -> None:
    with pytest.raises(InputError) as caught:
        sensitivity(scene, scales=("clock",))
    assert caught.value.where == "scales" and "heater_power" in caught.value.limit


def test_patches_share_the_slope_of_the_whole(
    found: Sensitivity, block: Path, meshing: Meshing
) -> None:
    whole = found.slopes["cooling"][..., :1]
    parts = sensitivity(
        block, runs=("cooling",), initial=INITIAL, meshing=meshing, stepping=STEPPING,
        choice=Patchwise(patches=3),
    )  # fmt: skip
    assert parts.names == ("conductivity",) * 3
    total = parts.slopes["cooling"].sum(-1, keepdims=True)
    assert np.abs(total - whole).max() < 1e-3 * np.abs(whole).max()


def test_a_network_is_refused_before_any_work(
    block: Path, meshing: Meshing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "scaled_slopes", None)
    with pytest.raises(InputError, match="other unknowns than the values"):
        sensitivity(block, runs=("cooling",), initial={"conductivity": VALUE}, meshing=meshing,
                    choice=Network(count=3, width=4, depth=1))  # fmt: skip

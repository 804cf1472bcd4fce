"""A scene as a function of logarithms: slopes against differences, priors, bounds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import LogModel, Meshing, Prior, Stepping, log_model
from thermo.inverse._reading_errors import whiten, without

pytestmark = pytest.mark.usefixtures("bricks")

UNKNOWN = ("convection", "conductivity")


@pytest.fixture(scope="module")
def model(block: Path, tmp_path_factory: pytest.TempPathFactory) -> LogModel:
    meshing = Meshing(order=1, max_nodes=600, cache=tmp_path_factory.mktemp("coarse"))
    return log_model(
        block, runs=("lamp",), unknown=UNKNOWN, initial={"conductivity": 0.8, "convection": 20.0},
        prior=Prior(spread={"convection": 0.1}), meshing=meshing,
        stepping=Stepping(tolerance=0.1, rtol=1e-9),
    )  # fmt: skip


def test_slopes_are_differences(model: LogModel) -> None:
    assert model.names == UNKNOWN
    assert np.exp(model.first) == pytest.approx([20.0, 0.8])
    at = model.first + [0.1, -0.2]
    _, slopes = model(at)
    for number in range(2):
        step = 1e-3 * np.eye(2)[number]
        wanted = (model(at + step)[0] - model(at - step)[0]) / 2e-3
        assert slopes[:, number] == pytest.approx(wanted, abs=1e-4 * np.abs(wanted).max())


def test_fields_that_a_compiled_function_returned_in_another_order_change_nothing(
    model: LogModel,
) -> None:
    returned = eqx.filter_jit(lambda fields: fields)(model.objective.fields)
    assert tuple(returned) != model.names
    again = replace(model, objective=replace(model.objective, fields=returned))
    for before, after in zip(model(model.first), again(model.first), strict=True):
        assert np.allclose(before, after, rtol=1e-9)


def test_a_prior_is_a_residual_beside_the_readings(model: LogModel) -> None:
    before, _ = model(model.first)
    after, _ = model(model.first + [0.2, 0.0])
    # A spread of 10 % and a convection that is 20 % up: two standard deviations.
    moved = (after - before)[-2 * (1 + 1) :]
    assert np.isclose(moved, 2.0).sum() == 1


def test_what_cells_and_steps_make_wrong_is_taken_off_and_what_is_left_is_doubted(
    model: LogModel,
) -> None:
    (group,) = model.objective.cases
    wanted = jax.vmap(whiten)(group.errors, group.used, group.defect / 3)
    assert np.abs(group.defect).max() > 1e-3 and np.allclose(group.shared, wanted)
    undoubted = replace(group, shared=jnp.zeros_like(group.shared))
    bold = replace(model, objective=replace(model.objective, cases=(undoubted,)))
    count = group.data.size
    surely, doubtfully = bold(model.first)[0][:count], model(model.first)[0][:count]
    by_hand = without(group.shared[0], jnp.asarray(surely).reshape(group.data.shape[1:]))
    assert np.allclose(doubtfully, np.asarray(by_hand).ravel(), atol=1e-8)
    assert np.sum(doubtfully**2) < np.sum(surely**2)


def test_values_beyond_their_bounds_are_refused(model: LogModel) -> None:
    with pytest.raises(InputError) as caught:
        model(np.array([model.bounds[0, 1] + 0.1, model.first[1]]))
    assert caught.value.where == "convection" and "W/m2/K" in caught.value.limit

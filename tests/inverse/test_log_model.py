"""A scene as a function of logarithms: slopes against differences, priors, bounds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import LogModel, Meshing, Prior, Stepping, log_model

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


def test_a_prior_is_a_residual_beside_the_readings(model: LogModel) -> None:
    before, _ = model(model.first)
    after, _ = model(model.first + [0.2, 0.0])
    # A spread of 10 % and a convection that is 20 % up: two standard deviations.
    moved = (after - before)[-2 * (1 + 1) :]
    assert np.isclose(moved, 2.0).sum() == 1


def test_values_beyond_their_bounds_are_refused(model: LogModel) -> None:
    with pytest.raises(InputError) as caught:
        model(np.array([model.bounds[0, 1] + 0.1, model.first[1]]))
    assert caught.value.where == "convection" and "W/m2/K" in caught.value.limit

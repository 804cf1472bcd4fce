"""Shifts by a stated value that is wrong, against fits of made-up readings."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import shifts
from thermo.inverse import Sensitivity

NAMES = ("conductivity", "heater_power", "convection")
FRAMES, SAMPLES, NOISE = 6, 10, 0.05


def made(seed: int = 0) -> Sensitivity:
    slopes = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES, 3))
    return Sensitivity(NAMES, {"a": slopes}, {"a": NOISE}, values=(1.0, 1.0, 10.0))


def test_a_fit_with_a_wrong_power_moves_as_told() -> None:
    at = made()
    matrix = at.slopes["a"].reshape(-1, 3)
    # Readings of a lamp 2 % brighter than stated: the simulation lacks that much.
    lacking = 0.02 * matrix[:, 1]
    fitted = np.linalg.lstsq(matrix[:, [0, 2]], lacking, rcond=None)[0]
    found = shifts(at, {"heater_power": 0.02}, model_error=0.0)
    told = {one.name: one for one in found}
    assert set(told) == {"conductivity", "convection"}
    wanted = dict(zip(("conductivity", "convection"), fitted, strict=True))
    for name, one in told.items():
        # The shift is that of a stated value too large, the other way round.
        assert one.relative == pytest.approx(-wanted[name], rel=1e-3)
        assert one.held == "heater_power" and one.doubt == 0.02
    assert abs(found[0].deviations) >= abs(found[1].deviations)
    covariance = np.linalg.inv(matrix[:, [0, 2]].T @ matrix[:, [0, 2]]) * NOISE**2
    sd = float(np.sqrt(covariance[0, 0]))
    assert told["conductivity"].deviations == pytest.approx(
        told["conductivity"].relative / sd, rel=1e-3
    )


def test_what_does_the_same_takes_it_all() -> None:
    at = made()
    at.slopes["a"][..., 0] = at.slopes["a"][..., 1]
    found = {one.name: one.relative for one in shifts(at, {"heater_power": 0.1}, model_error=0.0)}
    assert found["conductivity"] == pytest.approx(-0.1, rel=1e-3)
    assert found["convection"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("doubt", "where"),
    [
        ({"emissivity": 0.1}, "doubt.emissivity"),
        ({"heater_power": -0.1}, "doubt.heater_power"),
        (dict.fromkeys(NAMES, 0.1), "doubt"),
    ],
)
def test_a_doubt_that_cannot_be_is_refused(doubt: dict[str, float], where: str) -> None:
    with pytest.raises(InputError) as caught:
        shifts(made(), doubt)
    assert caught.value.where == where

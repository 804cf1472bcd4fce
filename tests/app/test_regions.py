"""Profiles of means over regions, as far as their time goes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from posteriors import MESH, SIZE, left, smoothness

from thermo.app._regions import LEAST, region_means
from thermo.identify import region_profile
from thermo.inverse import FieldLoss, FieldPosterior

EVERYWHERE = np.ones(len(MESH.faces), bool)


def simulated(made: list[int], fourth: float = 0.0) -> FieldPosterior:
    """What data leave open whose sum of squares is a parabola, or steeper; `made` is added to."""

    def of(departures: np.ndarray) -> tuple[float, np.ndarray]:
        made.append(1)
        square = departures @ departures
        slope = departures / 0.01 + 2 * fourth * square * departures
        return float(square / 0.01 + fourth * square**2), slope

    loss = FieldLoss(of, np.zeros(SIZE), np.eye(SIZE) / 0.01)
    return replace(left(smoothness(0.1)), loss=loss)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Simulations, of which each takes 10 s."""
    counted: list[int] = []
    clock = SimpleNamespace(monotonic=lambda: 10.0 * len(counted))
    monkeypatch.setattr("thermo.app._time_limit.time", clock)
    return counted


def test_a_parabola_takes_the_fewest_simulations() -> None:
    made: list[int] = []
    assert region_profile(simulated(made), "convection", EVERYWHERE).kind == "bounded"
    assert len(made) == LEAST


@pytest.mark.parametrize(("budget", "profiles"), [(149.0, 0), (150.0, 1), (1000.0, 2)])
def test_a_profile_that_cannot_end_in_time_is_not_begun(
    made: list[int], budget: float, profiles: int
) -> None:
    means, missed = region_means(simulated(made), {"lid": EVERYWHERE}, budget)
    names = ["conductivity", "convection"]
    assert [one.quantity for one in means if one.profile is not None] == names[:profiles]
    # One that compiles and one that is timed come first.
    assert len(made) == 2 + LEAST * profiles
    which = ", ".join(f"{name} over lid" for name in names[profiles:])
    wanted = f"Profiles of means, {which}: {budget:g} s did not suffice (simulations made: "
    wanted += f"{1 + LEAST * profiles}, 10 s each); raise budget, one profile takes 14 or more."
    assert missed == [wanted] * (profiles < 2)


def test_a_profile_is_left_within_it_when_time_is_spent(made: list[int]) -> None:
    means, (missed,) = region_means(simulated(made, 1e6), {"lid": EVERYWHERE}, 150.0)
    assert all(one.profile is None for one in means) and "raise budget" in missed
    assert len(made) == 2 + LEAST + 1


def test_nothing_is_simulated_without_time(made: list[int]) -> None:
    means, (missed,) = region_means(simulated(made), {"lid": EVERYWHERE}, 0.0)
    assert made == [] and missed.endswith("budget is 0.")
    assert all(one.profile is None for one in means)

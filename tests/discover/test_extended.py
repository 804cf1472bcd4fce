"""Fields and candidates as one point: its readings, residual and slopes, on two small runs."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import FRAMES, HOT, LAMP, at, one, run

from thermo.discover import Candidate
from thermo.discover._at_rest import rest_residual
from thermo.discover._entries import entries, entry_of, field_entries, free_entries, joined
from thermo.discover._extended import (
    WIDTH,
    Extended,
    columns,
    moved,
    numbers,
    readings,
    signatures,
    whitened,
)
from thermo.discover.candidates import (
    AmbientDrift,
    CameraEmissivity,
    ClockOffset,
    LocalConvection,
    SensorLag,
)
from thermo.inverse import Objective, penalty, start
from thermo.inverse._addition import read_as

from .lit_objective import objective as made
from .lit_objective import parts

TOP = (0.013, 0.006, 0.008)  # m


def candidates(strength: float = 1.0) -> tuple[Candidate, ...]:
    """A patch, a history and a sensor, at a share of what would be large [1]."""
    return (
        LocalConvection(strength * one(60.0), at(TOP, 0.005)),
        AmbientDrift(
            # Not weakly typed: a point that has moved is not, and would be another program.
            strength * jnp.asarray([2.0, 1.0, 4.0]),
            duration=jnp.asarray(FRAMES[-1], float),
        ),
        SensorLag(strength * one(2.0)),
    )


@pytest.fixture(scope="module")
def objective() -> Objective:
    return made()


@pytest.fixture(scope="module")
def point(objective: Objective) -> Extended:
    return Extended(start(objective), candidates())


@pytest.fixture(scope="module")
def ways(point: Extended) -> np.ndarray:
    """All that may be free: more ways than one pass takes."""
    corners = np.array([[0.0, 0, 0], [0.02, 0.012, 0.008]])
    names = ("local_convection", "ambient_drift", "sensor_lag")
    free = [
        free_entries(point, entry_of(point, (name, 0)), before, corners)
        for name, before in zip(names, point.candidates, strict=True)
    ]
    return joined(field_entries(point, point.fields), *free).ways(numbers(point).count)


@pytest.fixture(scope="module")
def found(objective: Objective, point: Extended, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # More than WIDTH of them, so that a second pass is needed.
    twice = np.concatenate([ways, ways[:2] + ways[2:4]])
    return columns(objective, point, twice)


def value_at(objective: Objective, point: Extended) -> np.ndarray:
    """The residual alone, by the program that the slopes have."""
    return columns(objective, point, np.zeros((WIDTH, numbers(point).count)))[0]


def test_slopes_are_those_of_differences(
    objective: Objective, point: Extended, ways: np.ndarray, found: tuple[np.ndarray, np.ndarray]
) -> None:
    value, slopes = found
    np.testing.assert_allclose(value_at(objective, point), value, atol=1e-12)
    assert slopes.shape == (len(value), len(ways) + 2) and len(ways) + 2 > WIDTH
    step = 1e-4
    for way, slope in zip(ways, slopes.T, strict=False):
        ahead, behind = (value_at(objective, moved(point, s * step * way)) for s in (1, -1))
        scale = np.abs(slope).max()
        assert scale > 1e-2
        np.testing.assert_allclose((ahead - behind) / (2 * step), slope, rtol=0, atol=1e-5 * scale)


def test_slopes_of_a_second_pass_are_those_of_the_first(
    found: tuple[np.ndarray, np.ndarray],
) -> None:
    _, slopes = found
    # Slopes are linear in the way; the last two ways are sums of four of the first.
    wanted = slopes[:, :2] + slopes[:, 2:4]
    np.testing.assert_allclose(slopes[:, -2:], wanted, atol=1e-8 * np.abs(wanted).max())


def test_signatures_are_the_slopes_by_strengths_alone(
    objective: Objective, point: Extended, ways: np.ndarray, found: tuple[np.ndarray, np.ndarray]
) -> None:
    value, slopes = found
    every = np.concatenate([one.strengths for one in entries(point)])
    assert len(every) == 5
    strengths = signatures(objective, point, np.eye(len(every)))
    assert strengths.shape == (len(value), len(every))
    for number, strength in zip(every, strengths.T, strict=True):
        (way,) = (row for row, one in enumerate(ways) if one[number] and np.count_nonzero(one) == 1)
        wanted = slopes[:, way] / ways[way, number]
        np.testing.assert_allclose(strength, wanted, atol=1e-7 * np.abs(wanted).max())
    assert np.all(strengths[parts(objective)[-1].stop :] == 0), "priors know no strength"


def test_priors_come_last_and_know_no_candidates(
    objective: Objective, point: Extended, found: tuple[np.ndarray, np.ndarray], ways: np.ndarray
) -> None:
    value, slopes = found
    last = parts(objective)[-1].stop
    assert len(value) > last
    priors = value[last : len(value) - len(objective.sequence)]
    np.testing.assert_allclose(priors, penalty(objective, point.fields), atol=1e-12)
    fields = len(field_entries(point, point.fields).number)
    assert np.all(slopes[last:, fields : len(ways)] == 0)
    assert np.abs(slopes[last:, :fields]).max(0).min() > 0.1


def test_what_a_body_reads_at_rest_comes_after_priors() -> None:
    hot = (run("lamp", lamp=LAMP, quiet=True), run("hot", initial=HOT, quiet=True))
    both = made(hot)
    wrong = CameraEmissivity(jnp.asarray([0.1]))
    point = Extended(start(both), (wrong,))
    every = np.eye(numbers(point).count)
    value, slopes = columns(both, point, every)
    rest = rest_residual(both.cases, (wrong,))
    np.testing.assert_allclose(value[-2:], rest, atol=1e-12)
    strength = entry_of(point, ("camera_emissivity", 0)).strengths[0]
    # Twice the strength, twice the difference: none of it comes from the readings.
    np.testing.assert_allclose(
        slopes[-2:, strength], 10 * (rest - rest_residual(both.cases, ())), atol=1e-9
    )
    assert np.all(np.delete(slopes[-2:], strength, axis=1) == 0)
    there = signatures(both, point, np.eye(1))
    np.testing.assert_allclose(there[-2:, 0], slopes[-2:, strength], atol=1e-9)


def test_what_is_read_less_the_data_is_the_residual(
    objective: Objective, point: Extended, found: tuple[np.ndarray, np.ndarray]
) -> None:
    read = readings(objective, point)
    apart = [group - case.data for group, case in zip(read, objective.cases, strict=True)]
    white = np.asarray(whitened(objective, apart))
    np.testing.assert_allclose(white, found[0][: len(white)], atol=1e-6)
    assert len(white) == parts(objective)[-1].stop
    (case,) = objective.cases
    assert np.all(white[np.asarray(case.used).ravel() == 0] == 0), "nothing is read there"


def test_each_run_is_read_under_its_own_conditions(objective: Objective, point: Extended) -> None:
    (group,) = readings(objective, point)
    first = np.asarray(group)[:, 0]
    levels = {objective.sequence[row]: float(first[row, 0]) for row in range(2)}
    assert levels[0] == pytest.approx(295.0, abs=1e-6)
    # The first frame of the other is a quarter of a second after its start, at which it is hot.
    assert 330.0 < levels[1] < 335.0


@pytest.mark.parametrize(
    "candidate",
    [
        SensorLag(jnp.zeros(1)),
        CameraEmissivity(jnp.zeros(1)),
        ClockOffset(jnp.zeros(1)),
    ],
    ids=lambda one: one.card.name,
)
def test_absent_errors_of_a_camera_leave_a_run_that_was_filled_up(
    objective: Objective, candidate: Candidate
) -> None:
    (case,) = objective.cases
    row = objective.sequence.index(1)
    alone = jax.tree.map(lambda leaf: leaf[row], case)
    assert alone.between is not None
    used = np.asarray(alone.used) > 0
    assert not used[-1].any(), "its last frames are none of the run's"
    # What a body that warms by a kelvin from step to step reads, as the objective reads it.
    warming = 300.0 + jnp.arange(alone.between.shape[1])
    body = alone.between @ jnp.repeat(warming[:, None], used.shape[1], 1)
    pinned = jnp.zeros(used.shape[1])
    read = read_as(body, alone.time, alone.under, pinned, (candidate,))
    np.testing.assert_allclose(np.asarray(read)[used], np.asarray(body)[used], atol=1e-9)

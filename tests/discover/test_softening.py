"""Smooth shapes count for less: by the share that is promised, and nothing else does."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.discover._extended import whitened
from thermo.discover._modes import space_modes, time_modes
from thermo.discover._softening import (
    STAMP,
    Block,
    blocks,
    error_columns,
    in_shapes,
    omnibus,
    shape_products,
    softened,
    stamp_columns,
)
from thermo.discover.candidates import ClockOffset
from thermo.inverse import DEFECT_LEFT, Objective, Task

from .lit_objective import RUNS, box_task, objective

SPREADS = (3.0, 0.2)
PRIORS = 5


def block(name: str, begin: int, frames: int, samples: int, spread: float) -> Block:
    points = np.random.default_rng(samples).uniform(0, 0.02, (samples, 3))
    return Block(
        name,
        slice(begin, begin + frames * samples),
        (frames, samples),
        time_modes(frames),
        space_modes(points),
        1 - 1 / np.sqrt(1 + spread),
        1.05,
        frames * samples,
    )


@pytest.fixture(scope="module")
def made() -> list[Block]:
    """Two runs of different shapes; more frames and samples than smooth shapes."""
    first = block("first", 0, 18, 20, SPREADS[0])
    return [first, block("second", first.part.stop, 15, 17, SPREADS[1])]


@pytest.fixture(scope="module")
def count(made: list[Block]) -> int:
    return made[-1].part.stop + PRIORS


def shape(of: Block, count: int, along: int, across: int) -> np.ndarray:
    """One smooth shape as values of the residual, of length one."""
    values = np.zeros(count)
    values[of.part] = np.outer(of.in_time[:, along], of.in_space[:, across]).ravel()
    return values


def rough(made: list[Block], count: int) -> np.ndarray:
    """Noise without what the smooth shapes hold of it; the priors' values as they are."""
    values = np.random.default_rng(0).normal(size=count)
    for one in made:
        smooth = one.in_time @ one.coefficients(values) @ one.in_space.T
        values[one.part] -= smooth.ravel()
    return values


@pytest.mark.parametrize("number", [0, 1])
def test_of_a_smooth_shape_a_share_is_left(made: list[Block], count: int, number: int) -> None:
    one = made[number]
    for along, across in [(0, 0), (3, 7), (11, 15)]:
        values = shape(one, count, along, across)
        left = softened(made, values[:, None])[:, 0]
        np.testing.assert_allclose(left, values / np.sqrt(1 + SPREADS[number]), atol=1e-12)


def test_all_else_is_untouched(made: list[Block], count: int) -> None:
    values = rough(made, count)
    assert np.linalg.norm(values) > 10
    np.testing.assert_allclose(softened(made, values[:, None])[:, 0], values, atol=1e-12)


def test_what_is_smooth_stays_orthogonal_to_all_else(made: list[Block], count: int) -> None:
    smooth = shape(made[0], count, 2, 3) + shape(made[1], count, 1, 1)
    values = np.stack([smooth, rough(made, count), shape(made[0], count, 3, 3)], 1)
    before = values.copy()
    left = softened(made, values)
    np.testing.assert_allclose(left.T @ left - np.diag(np.diag(left.T @ left)), 0, atol=1e-10)
    np.testing.assert_array_equal(values, before)
    # Column by column, and the same whichever others there are.
    np.testing.assert_allclose(left[:, 0], softened(made, values[:, :1])[:, 0], atol=1e-13)


def test_what_is_softened_has_variance_one(made: list[Block], count: int) -> None:
    # Noise, and smooth shapes whose variance is the spread: the covariance that is promised.
    one, draws = made[0], 4000
    make = np.random.default_rng(1)
    along, across = one.in_time.shape[1], one.in_space.shape[1]
    values = make.normal(size=(draws, count))
    wide = np.sqrt(SPREADS[0]) * make.normal(size=(draws, along, across))
    values[:, one.part] += (one.in_time @ wide @ one.in_space.T).reshape(draws, -1)
    left = softened(made, values.T)
    told = np.array([one.coefficients(column)[1, 2] for column in left.T])
    assert np.var(told) == pytest.approx(1.0, abs=0.1)
    raw = np.array([one.coefficients(column)[1, 2] for column in values])
    assert np.var(raw) == pytest.approx(1 + SPREADS[0], rel=0.1)


def test_the_omnibus_is_the_energy_in_smooth_shapes(made: list[Block], count: int) -> None:
    values = 3 * shape(made[0], count, 4, 4) - 2 * shape(made[1], count, 0, 5)
    told, shapes, each = omnibus(made, values + rough(made, count))
    assert told == pytest.approx(13.0) and each == pytest.approx({"first": 9.0, "second": 4.0})
    assert shapes == 2 * 12 * 16


def test_coefficients_of_columns_are_those_of_each_run(made: list[Block], count: int) -> None:
    columns = np.random.default_rng(4).normal(size=(count, 3))
    found = in_shapes(made, columns)
    for number, values in enumerate(columns.T):
        each = [one.coefficients(values).ravel() for one in made]
        np.testing.assert_allclose(found[:, number], np.concatenate(each), atol=1e-12)


def test_products_of_shapes_are_in_the_order_of_their_coefficients() -> None:
    # Neither orthogonal nor of length one, so that no two may change places.
    random = np.random.default_rng(5)
    runs = [
        replace(
            block(name, begin, 18, 20, 1.0),
            in_time=random.normal(size=(18, 3)),
            in_space=random.normal(size=(20, 4)),
        )
        for name, begin in (("first", 0), ("second", 18 * 20))
    ]
    every = np.stack(
        [
            shape(one, 2 * 18 * 20, along, across)
            for one in runs
            for along in range(3)
            for across in range(4)
        ],
        1,
    )
    np.testing.assert_allclose(shape_products(runs), every.T @ every, atol=1e-12)
    np.testing.assert_allclose(in_shapes(runs, every), every.T @ every, atol=1e-12)


@pytest.fixture(scope="module")
def real() -> Objective:
    """Two runs of which the second has fewer frames and samples."""
    return objective()


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> Task:
    return box_task(tmp_path_factory.mktemp("box"))


def errors(of: Objective) -> np.ndarray:
    """What cells are made to do wrong [K], (runs, frames, samples)."""
    data = of.cases[0].data
    return 0.3 * np.random.default_rng(2).normal(size=data.shape)


def test_blocks_are_the_runs_as_they_stand_in_the_residual(real: Objective, task: Task) -> None:
    apart = errors(real)
    found = blocks(real, task, [jnp.asarray(apart)])
    assert [one.name for one in found] == [RUNS[number].name for number in real.sequence]
    (case,) = real.cases
    begin = 0
    for row, one in enumerate(found):
        used, weight = np.asarray(case.used)[row], np.asarray(case.weight())[row]
        assert one.part == slice(begin, begin + used.size) and one.shape == used.shape
        begin += used.size
        samples = len(RUNS[real.sequence[row]].recording.points)
        across = one.in_space[:samples]
        np.testing.assert_allclose(across.T @ across, np.eye(samples), atol=1e-10)
        assert np.all(one.in_space[samples:] == 0), "samples that were filled up"
        frames = len(RUNS[real.sequence[row]].recording.time)
        along = one.in_time[:frames]
        np.testing.assert_allclose(along.T @ along, np.eye(along.shape[1]), atol=1e-10)
        assert np.all(one.in_time[frames:] == 0), "frames that were filled up"
        assert one.readings == np.count_nonzero(used)
        wrong = (DEFECT_LEFT * apart[row]) ** 2 + task.model_error**2
        energy = (weight**2 * used * wrong).sum()
        spread = energy / (one.in_time.shape[1] * one.in_space.shape[1])
        assert one.share == pytest.approx(1 - (1 + spread) ** -0.5) and 0.1 < one.share < 1
    sure = replace(task, model_error=0.0)
    none = blocks(real, sure, [jnp.zeros(apart.shape)])
    assert all(one.share == 0 for one in none)


def test_error_columns_are_a_share_of_the_errors_run_by_run(real: Objective, task: Task) -> None:
    apart = [jnp.asarray(errors(real))]
    found = blocks(real, task, apart)
    count = found[-1].part.stop + PRIORS
    made = error_columns(found, real, apart, count)
    assert made.shape == (count, 2) and np.all(made[-PRIORS:] == 0)
    white = np.asarray(whitened(real, apart))
    np.testing.assert_allclose(made.sum(1)[:-PRIORS], DEFECT_LEFT * white)
    assert np.all(made[found[0].part, 1] == 0) and np.all(made[found[1].part, 0] == 0)
    assert np.abs(made).max(0).min() > 0.1


def test_stamp_columns_are_what_a_run_would_read_a_little_later(
    real: Objective, task: Task
) -> None:
    (case,) = real.cases
    time = np.asarray(case.time)[:, :, None]
    # Straight lines of another slope for each sample, whose frames are three seconds apart.
    rates = np.array([1.0, -2.0, 0.5, 3.0])
    lines = 300.0 + rates * time
    found = blocks(real, task, [jnp.zeros(lines.shape)])
    count = found[-1].part.stop + PRIORS
    made = stamp_columns(found, real, [jnp.asarray(lines)], count)
    assert made.shape == (count, 2) and np.all(made[-PRIORS:] == 0)
    # Where a run has no frames, it has none that could be late.
    lacking = np.diff(time[:, :, 0], axis=1, prepend=-1.0) == 0
    assert lacking.any() and lacking.any(1).sum() == 1
    # Before the first frame all is taken to be as there, and so from there on.
    still = lacking | (np.arange(time.shape[1]) == 0)
    late = np.where(still[:, :, None], 0.0, STAMP * 3.0 * rates + 0 * time)
    white = np.asarray(whitened(real, [jnp.asarray(late)]))
    np.testing.assert_allclose(made.sum(1)[:-PRIORS], white, atol=1e-9 * np.abs(white).max())
    assert np.all(made[found[0].part, 1] == 0) and np.all(made[found[1].part, 0] == 0)


def test_stamps_are_off_as_a_clock_is_also_just_after_a_switch(real: Objective, task: Task) -> None:
    (case,) = real.cases
    time = case.time[:, :, None]
    # The root of time is what a skin follows where a lamp has been lit.
    read = 300.0 + jnp.sqrt(time) * jnp.array([1.0, -2.0, 0.5, 3.0])
    found = blocks(real, task, [jnp.zeros(read.shape)])
    made = stamp_columns(found, real, [read], found[-1].part.stop)

    def clock(row: int) -> jax.Array:
        under = jax.tree.map(lambda leaf: leaf[row], case.under)

        def late(by: jax.Array) -> jax.Array:
            return ClockOffset(by).to_readings(read[row], case.time[row], under)

        return jax.jvp(late, (jnp.zeros(1),), (jnp.ones(1),))[1]

    lacking = np.diff(np.asarray(case.time), axis=1, prepend=-1.0) == 0
    slopes = np.stack([clock(row) for row in range(len(lacking))])
    white = whitened(real, [jnp.asarray(np.where(lacking[:, :, None], 0.0, STAMP * 3.0 * slopes))])
    np.testing.assert_allclose(made.sum(1), white, atol=1e-9 * np.abs(np.asarray(white)).max())

"""Steps laid out before a run."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.mesh import box_mesh
from thermo.physics import (
    ConjugateGradient,
    Model,
    TimeGrid,
    assemble,
    discretise,
    every_step,
    lengthened,
    plan_steps,
    rounded_up,
    solve_heat,
    uniform_steps,
)
from thermo.physics.effects import Convection, Heating, Schedule, patch_profile
from thermo.physics.integrators import Sdirk2, step_with_error

simulate = eqx.filter_jit(solve_heat)
FRAMES = np.arange(0.0, 21.0, 2.0)
SWITCHES = (0.0, 7.3)


def ends(grid: TimeGrid) -> np.ndarray:
    return np.asarray(grid.start) + np.asarray(grid.size)


def assert_sound(grid: TimeGrid, switches: tuple[float, ...]) -> None:
    """Steps follow each other, land on their frames and never cross a switch."""
    start, end = np.asarray(grid.start), ends(grid)
    np.testing.assert_allclose(start, np.concatenate([[0.0], end[:-1]]), atol=1e-9)
    reached = np.concatenate([[0.0], end])[np.asarray(grid.frame_step)]
    np.testing.assert_allclose(reached, grid.frame_time, atol=2e-9)
    for switch in switches:
        assert not ((start < switch - 1e-9) & (end > switch + 1e-9)).any()


@given(
    gaps=st.lists(st.floats(0.01, 5.0), min_size=1, max_size=12),
    size=st.floats(0.02, 3.0),
    shares=st.lists(st.floats(0.0, 1.2), max_size=3),
    zero=st.booleans(),
)
def test_uniform_steps_are_sound(
    gaps: list[float], size: float, shares: list[float], zero: bool
) -> None:
    frames = np.cumsum([0.0, *gaps] if zero else gaps)
    switches = tuple(float(share * frames[-1]) for share in shares)
    grid = uniform_steps(frames, size, switches)
    assert_sound(grid, switches)
    np.testing.assert_array_equal(grid.frame_time, frames)
    assert (np.asarray(grid.size) <= size * (1 + 1e-6)).all()
    assert (np.asarray(grid.size) > 0).all()
    np.testing.assert_allclose(ends(grid)[-1], frames[-1])


def heated() -> tuple[Model, jnp.ndarray]:
    space = discretise(box_mesh((0.02, 0.01, 0.01), (6, 1, 1)))
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    lamp = patch_profile(space, np.flatnonzero(space.mesh.normals[:, 0] < -0.9))
    model = Model(
        space,
        jnp.full(cells, 0.4),
        jnp.full(cells, 1.5e6),
        surface=(
            Heating(0.8, lamp, Schedule(SWITCHES[1])),
            Convection(jnp.full(faces, 20.0), 290.0),
        ),
    )
    return model, jnp.full(len(space.mesh.nodes), 290.0)


def padded(grid: TimeGrid, count: int) -> TimeGrid:
    """The same grid with empty steps at its end, so that all grids share one program."""
    more = count - len(np.asarray(grid.start))
    assert more >= 0
    start = np.concatenate([grid.start, np.full(more, ends(grid)[-1])])
    return TimeGrid(
        start, np.concatenate([grid.size, np.zeros(more)]), grid.frame_step, grid.frame_time
    )


def test_planned_steps_keep_the_tolerance() -> None:
    model, initial = heated()
    frames = np.array([0.0, 3.0, 12.0, 20.0])
    fine = uniform_steps(frames, 0.02, SWITCHES)
    most = len(fine.start)

    def run(grid: TimeGrid) -> np.ndarray:
        return np.asarray(
            simulate(model, initial, padded(grid, most), integrator=Sdirk2()).temperature
        )

    exact = run(fine)
    assert np.ptp(exact) > 20
    tolerances, errors, counts = (0.3, 0.03, 0.003), [], []
    for tolerance in tolerances:
        grid = plan_steps(
            model, initial, frames, tolerance=tolerance, largest=5.0, switches=SWITCHES
        )
        assert_sound(grid, SWITCHES)
        np.testing.assert_array_equal(grid.frame_time, frames)
        errors.append(np.abs(run(grid) - exact).max())
        counts.append(len(grid.start))
    # Each step keeps the tolerance, and the errors of steps add up at most: with steps that
    # shrink like its cube root, what is left falls like its power 2/3.
    assert all(e < n * t for e, n, t in zip(errors, counts, tolerances, strict=True))
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert abs(slope - 2 / 3) < 0.2
    assert counts[0] < counts[1] < counts[2] < most / 4


@pytest.mark.parametrize("name", ["tolerance", "largest"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_steps_of_nothing_are_refused(name: str, value: float) -> None:
    model, initial = heated()
    limits = {"tolerance": 1e-3, "largest": 1.0, name: value}
    with pytest.raises(InputError, match=f"plan_steps: {name}"):
        plan_steps(model, initial, np.array([1.0]), **limits)


def test_the_estimate_of_a_step_is_its_error() -> None:
    model, initial = heated()
    balance = assemble(model)
    tight = ConjugateGradient(rtol=1e-12)

    @jax.jit
    def step(size: jax.Array, old: jax.Array) -> tuple[jax.Array, jax.Array]:
        return step_with_error(Sdirk2(), balance, old, 0.5, size, tight)

    start = initial
    for _ in range(50):  # past the jump at the start
        start, _ = step(jnp.asarray(0.05), start)
    sizes, estimates, errors = (0.2, 0.1, 0.05), [], []
    for size in sizes:
        new, estimate = step(jnp.asarray(size), start)
        parts = start
        for _ in range(16):
            parts, _ = step(jnp.asarray(size / 16), parts)
        estimates.append(float(estimate.max()))
        errors.append(float(jnp.abs(new - parts).max()))
    ratio = np.array(estimates) / np.array(errors)
    assert ((ratio > 0.1) & (ratio < 4)).all()
    slopes = [np.polyfit(np.log(sizes), np.log(v), 1)[0] for v in (estimates, errors)]
    assert min(slopes) > 2.6


def test_steps_follow_their_error_where_only_the_end_is_a_frame() -> None:
    model, initial = heated()
    grid = every_step(
        plan_steps(model, initial, np.array([20.0]), tolerance=0.3, largest=4.0, switches=SWITCHES)
    )
    assert_sound(grid, SWITCHES)
    assert 5 < len(grid.start) < 60
    assert np.asarray(grid.size).max() <= 4.0 + 1e-9
    np.testing.assert_allclose(grid.frame_time, np.append(0.0, ends(grid)))
    np.testing.assert_array_equal(grid.frame_step, np.arange(len(grid.start) + 1))


def test_steps_are_short_after_a_switch() -> None:
    model, initial = heated()
    grid = plan_steps(model, initial, FRAMES, tolerance=0.05, largest=5.0, switches=SWITCHES)
    after = np.flatnonzero(np.abs(np.asarray(grid.start) - SWITCHES[1]) < 1e-9)
    assert len(after) == 1
    before = after[0] - 2
    assert grid.size[after[0]] < 0.5 * grid.size[before]


@given(count=st.integers(1, 100000))
def test_counts_are_rounded_up_by_a_quarter_at_most(count: int) -> None:
    assert count <= rounded_up(count) <= max(1.25 * count, count)
    assert rounded_up(rounded_up(count)) == rounded_up(count)


def test_an_octave_has_few_counts() -> None:
    assert len({rounded_up(count) for count in range(64, 128)}) <= 5


def test_steps_of_no_duration_change_nothing() -> None:
    space = discretise(box_mesh((0.01, 0.01, 0.01), (3, 3, 3)))
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    air = Convection(jnp.full(faces, 20.0), 290.0)
    model = Model(space, jnp.full(cells, 0.2), jnp.full(cells, 1e6), (air,))
    grid = every_step(uniform_steps(FRAMES, 1.7, SWITCHES))
    more = lengthened(grid, len(grid.start) + 5, len(grid.frame_time) + 3)
    assert not more.even
    first = jnp.full(len(space.mesh.nodes), 320.0)
    solver = ConjugateGradient(rtol=1e-10)
    one, other = (
        simulate(model, first, each, integrator=Sdirk2(), solver=solver).temperature
        for each in (grid, more)
    )
    np.testing.assert_allclose(other[: len(one)], one, rtol=1e-12)
    np.testing.assert_array_equal(other[len(one) :], np.repeat(other[-1:], 3, axis=0))

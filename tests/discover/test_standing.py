"""What a standing leaves, and how much of it another one closes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import MESH, STATED, one
from standings import standing

from thermo.discover import Place, _standing
from thermo.discover._bench import Apart, Bench
from thermo.discover._candidate import with_edge
from thermo.discover._descent import Free
from thermo.discover._slope_limits import slope_limits
from thermo.discover._standing import (
    Standing,
    fitted,
    free_of,
    lost,
    measured,
    not_moved,
    refined,
    share_closed,
    with_few_places,
)
from thermo.discover.candidates import (
    LocalConvection,
    MissingRadiation,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
)
from thermo.errors import InputError
from thermo.inverse import Ready, Task
from thermo.physics.effects import TabulatedLaw

from .lit_objective import RUNS, box_task, objective, partly, standing_at

FREE = Free(np.array([0]), np.ones(1), -np.ones(1), np.ones(1), np.zeros(1, bool))


def test_what_is_left_is_never_less_than_noise() -> None:
    assert standing(50.0, 2, smooth=0.2).misfit() == 1.0
    assert standing(50.0, 2, smooth=7.0).misfit() == pytest.approx(7.0)


def test_the_share_closed_is_of_what_is_beyond_noise_and_one_at_the_most() -> None:
    before = standing(200.0, 2, smooth=101.0)
    assert share_closed(before, standing(100.0, 3, smooth=51.0)) == pytest.approx(0.5)
    assert share_closed(before, standing(40.0, 3, smooth=0.1)) == 1.0
    assert share_closed(before, before) == 0.0
    # A gap within the scatter of one square of noise is no measure: that scatter is.
    small = standing(60.0, 2, smooth=1.5)
    assert share_closed(small, standing(60.0, 3)) == pytest.approx(0.5 / np.sqrt(2))


def test_a_fit_makes_room_for_its_program(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without it a long search came to what the system allows a process, and was aborted.
    class AskedFor(Exception):
        pass

    def make_room() -> None:
        raise AskedFor

    monkeypatch.setattr(_standing, "make_room", make_room)
    with pytest.raises(AskedFor):
        fitted(standing(60.0, 2), times=0)


@pytest.mark.parametrize("rough", [False, True])
def test_what_the_smallest_cells_leave_scatters_scores_where_cells_are_rough(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, rough: bool
) -> None:
    small = Bench(box_task(tmp_path), Ready(MESH, STATED, {}, {}, {}, {}), objective(), MESH)
    smallest = replace(small)
    made = standing(60.0, 1)
    before = Standing(small, {}, made.point, (), made.ended, made.allowed)
    one = jnp.asarray([[[3.0, jnp.nan]]])
    asked: list[Bench] = []

    def finer_runs(bench: Bench, _: object) -> Apart:
        asked.append(bench)
        return [one + 0.5] if bench is smallest else [one]

    def columns(_: object, __: object, apart: Apart, count: int, share: float) -> np.ndarray:
        # Of an error of second order, 4/5 of what edges of a half and of a third are apart is left.
        assert share == pytest.approx(0.8)
        return np.full((count, 1), share * float(np.asarray(apart[0]).sum()))

    def fit(anew: Standing, *, times: int) -> Standing:
        assert times == 0, "what cells make wrong is known there"
        return anew

    monkeypatch.setattr(_standing, "with_few_places", lambda one: (one, {}))
    monkeypatch.setattr(_standing, "finer_runs", finer_runs)
    monkeypatch.setattr(_standing, "corrected", lambda bench, *_: bench)
    monkeypatch.setattr(_standing, "error_columns", columns)
    monkeypatch.setattr(_standing, "fitted", fit)
    scatter = refined(before, smallest, rough=rough).bench.scatter
    assert len(asked) == (2 if rough else 1) and asked[0] is smallest
    # Of the error 0.4 in each value nothing is fitted away, and there is one smooth shape.
    values = len(before.ended.residual)
    assert scatter == pytest.approx(np.sqrt(1 + 0.4**2 * values) if rough else 1.0)


def test_a_point_that_fine_cells_cannot_take_leaves_infinitely_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def burst(*_: object) -> Apart:
        raise InputError("there cannot be", where="", value="-9e14 K", limit="0 K", remedy="units")

    monkeypatch.setattr(_standing, "finer_runs", burst)
    monkeypatch.setattr(_standing, "with_few_places", lambda one: (one, {}))
    monkeypatch.setattr(_standing, "with_all_places", lambda _, small, __: small)
    monkeypatch.setattr(_standing, "free_of", lambda _: FREE)
    here = standing(60.0, 1)
    assert not lost(here) and lost(measured(here))
    found = fitted(here, times=1)
    assert found.ended.loss() == np.inf and found.point is here.point
    # Nothing is asked of coarse cells there, which this one has none of.
    assert not_moved(found, FREE) is found


def test_a_law_is_free_as_far_as_it_stays_above_zero() -> None:
    laws = TemperatureDependentHeatCapacity(one(1e-3)), TemperatureDependentConductivity(one(1e-3))
    made = standing_at(objective(), *laws, MissingRadiation(one(0.1)))
    # Each keeps to its own law: a capacity that doubles in 20 K may be cut by more.
    grows = TabulatedLaw(jnp.array([293.15, 313.15]), jnp.array([1.0, 2.0]))
    stated = replace(STATED, capacity_law=grows)
    whole = partly(
        Bench, coarse=made.bench.coarse, ready=partly(Ready, mesh=MESH, stated=stated),
        task=partly(Task, runs=RUNS),
    )  # fmt: skip
    free = free_of(replace(made, bench=whole))
    capacity, conductivity = (slope_limits(law, RUNS) for law in (grows, None))
    assert -0.05 < capacity[0] < conductivity[0] < 0
    np.testing.assert_array_equal(free.low[-3:-1], [capacity[0], conductivity[0]])
    tops = np.minimum([capacity[1], conductivity[1]], 0.05)
    np.testing.assert_array_equal(free.high[-3:-1], tops)
    assert free.low[-1] == MissingRadiation.card.low


def test_a_patch_is_held_where_it_was_told_to_be() -> None:
    centres = jnp.asarray(MESH.nodes.mean(0)) + jnp.asarray([[0.0, 0.0, 0.0], [0.002, 0.0, 0.0]])
    even = with_edge(LocalConvection(jnp.asarray([0.0, 40.0]), Place(centres, jnp.full(2, 0.003))))
    made = standing_at(objective(), even)
    made = replace(made, active=(("local_convection", 1),))
    fields = len(free_of(replace(made, active=())).number)
    # Strength, middle, half-widths, squareness and sharpness.
    assert len(free_of(made).number) == fields + 9
    held = replace(made, held={("local_convection", 1): np.array([False, False, True])})
    assert len(free_of(held).number) == fields + 7
    # The one part that a fit looks at has another number there.
    few, kept = with_few_places(held)
    assert kept["local_convection"].tolist() == [1] and few.active == (("local_convection", 0),)
    assert len(free_of(few).number) == fields + 7

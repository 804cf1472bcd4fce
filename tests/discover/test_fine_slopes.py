"""Slopes of finer cells for light below the skin, of a toy that coarse cells get wrong."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from thermo.discover import Candidate, Place
from thermo.discover import _fine_slopes as module
from thermo.discover._allowance import Allowance
from thermo.discover._bench import Apart, Bench
from thermo.discover._descent import Ended, Free
from thermo.discover._extended import Extended
from thermo.discover._fine_slopes import by_fine_slopes
from thermo.discover._pace import Pace
from thermo.discover._standing import Standing
from thermo.discover.candidates import HeaterPower, InDepthAbsorption

SHARE, DEPTH = 0.7, 4e-4  # 1, m
# The field's logarithm, the share of the second of two depths, and that depth.
FREE = Free(
    np.array([0, 2, 4]), np.array([0.3, 0.5, 4e-4]), np.array([-9.0, 0.0, 1e-4]),
    np.array([9.0, 1.0, 2e-3]), np.array([True, False, False]),
)  # fmt: skip


def point(field: float, share: float, depth: float) -> Extended:
    light = InDepthAbsorption(jnp.array([0.0, share]), Place(None, jnp.array([1e-3, depth])))
    return Extended({"x": {"value": jnp.array([field])}}, (light,))  # type: ignore[dict-item]


def fine(at: Extended) -> np.ndarray:
    """What finer cells read: field, share times depth, and share times its square, weakly."""
    field, _, share, _, depth = np.asarray(ravel_pytree(at)[0])
    deep = depth / DEPTH
    return np.array([50 * field + 20 * share, 900 * share * deep, 30 * share * deep**2, 0.0])


WANTED = fine(point(0.2, SHARE, DEPTH))


class Toy:
    """A standing on cells that are right where they were measured, and slopes of which are not."""

    def __init__(self, at: Extended, monkeypatch: pytest.MonkeyPatch) -> None:
        self.said: list[str] = []
        self.measured = 0
        ended = Ended(at, np.zeros(4), np.zeros((4, 3)))
        exact = Allowance([], np.zeros((4, 0)), np.zeros(0))
        active = (("in_depth_absorption", 1),)
        self.begun = Standing(object.__new__(Bench), {}, at, active, ended, exact)
        for name, fake in {
            "with_few_places": lambda one: (one, {}), "free_of": lambda _: FREE,
            "with_all_places": lambda _, small, __: small, "measured": lambda one: one,
            "not_moved": self.not_moved, "finer_runs": self.finer_runs,
            "steps_for": lambda *_: None, "whitened": lambda _, apart: np.asarray(apart[0]),
        }.items():  # fmt: skip
            monkeypatch.setattr(module, name, fake)
        monkeypatch.setattr(Bench, "coarse", None, raising=False)

    def not_moved(self, one: Standing, _: Free) -> Standing:
        self.measured += 1
        # As linear cells would, they know share times depth alone, and of the rest half.
        _, _, share, _, depth = np.asarray(ravel_pytree(one.point)[0])
        deep = depth / DEPTH
        slopes = np.array(
            [[50, 20, 0], [0, 900 * deep, 900 * share], [0, 15 * deep**2, 15 * share], [0, 0, 0]]
        )
        slopes = slopes * np.array([0.3, 0.5, 1.0])
        return replace(one, ended=Ended(one.point, fine(one.point) - WANTED, slopes))

    def finer_runs(self, _: Bench, at: Extended) -> Apart:
        return [jnp.asarray(fine(at))]

    def asked(self, doubted: Standing | None = None) -> tuple[Standing, Standing]:
        return by_fine_slopes(self.begun, doubted or self.begun, Pace(self.said.append))


def told(one: Standing) -> np.ndarray:
    return np.asarray(ravel_pytree(one.point)[0])[FREE.number]


@pytest.mark.parametrize(("share", "depth"), [(0.55, 5.3e-4), (1.0, 3e-4), (0.35, 8e-4)])
def test_light_ends_where_finer_cells_have_it(
    monkeypatch: pytest.MonkeyPatch, share: float, depth: float
) -> None:
    toy = Toy(point(0.1, share, depth), monkeypatch)
    found, doubted = toy.asked()
    # Two values of three hundred, and one of thirty.
    np.testing.assert_allclose(told(found), [0.2, SHARE, DEPTH], rtol=0.02)
    assert found.ended.loss() < 0.05
    # Slopes of what coarse cells get wrong are the finer ones', those of fields stay as they are.
    for number in (1, 2):
        change = np.zeros(5)
        change[FREE.number[number]] = 1e-6 * FREE.scale[number]
        flat, back = ravel_pytree(found.point)
        wanted = 1e6 * (fine(back(flat + change)) - fine(found.point))
        for one in (found, doubted):
            # Told over five per cent, in which that of the square of the depth grows by as much.
            np.testing.assert_allclose(one.ended.slopes[:, number], wanted, rtol=0.08, atol=1e-3)
    np.testing.assert_allclose(found.ended.slopes[:, 0], [15, 0, 0, 0])
    assert doubted.point is toy.begun.point
    (words,) = toy.said
    assert words.startswith("fitting light below the skin")


def test_coarse_slopes_would_have_led_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    # The test above tells of something only if they do.
    toy = Toy(point(0.2, 0.55, 4e-4 * 0.7 / 0.55), monkeypatch)
    monkeypatch.setattr(module, "_with", lambda one, *_: one.ended)
    found, _ = toy.asked()
    assert abs(told(found)[1] - SHARE) > 0.05


def test_a_step_that_leaves_more_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy(point(0.1, 0.5, 6e-4), monkeypatch)
    real = toy.not_moved

    def more(one: Standing, free: Free) -> Standing:
        made = real(one, free)
        if toy.measured == 1:
            return made
        worse = replace(made.ended, residual=made.ended.residual + 1e3)
        return replace(made, ended=worse)

    monkeypatch.setattr(module, "not_moved", more)
    found, _ = toy.asked()
    # Less of it is tried until what that promises is nothing.
    assert found.point is toy.begun.point and 3 <= toy.measured <= 7
    # Errors follow from finer slopes all the same.
    assert found.ended.slopes[2, 1] == pytest.approx(30 * 1.5**2 * 0.5, rel=0.03)


def test_a_share_of_next_to_nothing_grows_to_its_bound_at_the_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    toy = Toy(point(0.2, 1e-4, DEPTH), monkeypatch)
    first = toy.not_moved(toy.begun, FREE).ended.loss()
    found, _ = toy.asked()
    assert 1e-4 < told(found)[1] <= 1.0 and found.ended.loss() < first


def test_what_fine_cells_cannot_take_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy(point(0.1, 0.5, 6e-4), monkeypatch)

    def burst(one: Standing) -> Standing:
        return replace(one, ended=replace(one.ended, residual=np.full(4, np.inf)))

    monkeypatch.setattr(module, "measured", burst)
    monkeypatch.setattr(module, "not_moved", lambda one, _: one)
    found, doubted = toy.asked()
    assert found is toy.begun and doubted is toy.begun


def test_what_is_allowed_for_counts_in_the_slopes_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy(point(0.2, SHARE, DEPTH), monkeypatch)

    # Of the value that tells shares and depths apart half is taken off.
    softer = Allowance([], np.eye(4)[:, 2:3], np.array([0.5]))
    found, doubted = toy.asked(replace(toy.begun, allowed=softer))
    half = np.array([1.0, 1.0, 0.5, 1.0])[:, None]
    np.testing.assert_allclose(doubted.ended.slopes[:, 1:], half * found.ended.slopes[:, 1:])


@pytest.mark.parametrize("kinds", [(), (HeaterPower(jnp.array([0.1])),)])
def test_without_light_below_the_skin_all_stays(
    monkeypatch: pytest.MonkeyPatch, kinds: tuple[Candidate, ...]
) -> None:
    toy = Toy(point(0.2, SHARE, DEPTH), monkeypatch)
    names = tuple((one.card.name, 0) for one in kinds)
    bare = replace(toy.begun, point=replace(toy.begun.point, candidates=kinds), active=names)
    found, doubted = by_fine_slopes(bare, bare, Pace(toy.said.append))
    assert found is bare and doubted is bare and not toy.said

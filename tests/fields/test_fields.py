"""Fields: bounds, round trips, what freezing keeps, and derivatives."""

from __future__ import annotations

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.fields import (
    QUANTITIES,
    AbstractField,
    AbstractHead,
    ControlPoints,
    LinearHead,
    LogHead,
    control_point_field,
    encode,
    freeze,
    network_field,
    patchwise_field,
    place_control_points,
    uniform_field,
)
from thermo.mesh import Mesh, ball_mesh, promote

CONDUCTIVITY = QUANTITIES["conductivity"]
HEADS = {"log": LogHead(0.05, 50.0), "linear": LinearHead(0.05, 5.0)}
KINDS = ("uniform", "patchwise", "control_points", "network", "frozen")
SHARES = 0.5 ** np.arange(2, 7)


@cache
def ball() -> Mesh:
    return promote(ball_mesh(0.05, 2))


@cache
def controls() -> ControlPoints:
    return place_control_points(ball(), 9)


def field_of(kind: str, head: AbstractHead, initial: float = 1.3) -> AbstractField:
    if kind == "uniform":
        return uniform_field(CONDUCTIVITY, ball(), head, initial)
    if kind == "network":
        return network_field(CONDUCTIVITY, ball(), head, initial, controls(), width=8)
    make = patchwise_field if kind == "patchwise" else control_point_field
    field = make(CONDUCTIVITY, ball(), head, initial, controls())
    return freeze(field, np.arange(9) < 4) if kind == "frozen" else field


@given(
    raw=st.floats(-60, 60), low=st.floats(1e-9, 1e3), ratio=st.floats(1.5, 1e6), log=st.booleans()
)
def test_values_stay_within_bounds(raw: float, low: float, ratio: float, log: bool) -> None:
    head = (LogHead if log else LinearHead)(low, low * ratio)
    value, further = (float(head.value(jnp.asarray(u))) for u in (raw, raw + 1.0))
    slack = 1e-9 * low * ratio
    assert low - slack <= value <= further <= low * ratio + slack


@given(
    share=st.floats(0.01, 0.99),
    low=st.floats(1e-9, 1e3),
    ratio=st.floats(1.5, 1e6),
    log=st.booleans(),
)
def test_raw_and_value_are_inverse(share: float, low: float, ratio: float, log: bool) -> None:
    head = LogHead(low, low * ratio) if log else LinearHead(low, low * ratio)
    value = low * ratio**share if log else low + share * low * (ratio - 1)
    back = float(head.value(head.raw(jnp.asarray(value))))
    np.testing.assert_allclose(back, value, rtol=1e-9)


def test_log_head_has_unit_slope_in_the_middle() -> None:
    head = LogHead(0.01, 100.0)
    slope = jax.grad(lambda u: jnp.log(head.value(u)))(0.0)
    np.testing.assert_allclose(slope, 1.0, rtol=1e-12)
    np.testing.assert_allclose(head.value(jnp.zeros(())), 1.0, rtol=1e-12)


@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_field_starts_at_its_initial_value(kind: str, head: str) -> None:
    field = field_of(kind, HEADS[head])
    rough = 0.2 if kind == "network" else 1e-9
    for values, count in (
        (field.face_values(), len(ball().faces)),
        (field.cell_values(), len(ball().cells)),
    ):
        assert values.shape == (count,)
        np.testing.assert_allclose(values, 1.3, rtol=rough)


@pytest.mark.parametrize("kind", KINDS)
def test_constants_are_reproduced(kind: str) -> None:
    extension = field_of(kind, HEADS["log"]).extension
    flat = jnp.full(1 if kind == "uniform" else 9, 0.7)
    np.testing.assert_allclose(extension.to_faces(flat), 0.7, rtol=1e-14)
    np.testing.assert_allclose(extension.to_cells(flat), 0.7, rtol=1e-14)
    for weight in (extension.face_weight, extension.cell_weight):
        assert (np.asarray(weight) >= 0).all()
        np.testing.assert_allclose(np.asarray(weight).sum(1), 1.0, rtol=1e-13)


def test_interpolation_stays_between_its_controls_and_meets_them() -> None:
    field = field_of("control_points", HEADS["log"])
    raw = jnp.asarray(np.random.default_rng(0).normal(size=9))
    field = field.with_parameters(raw)
    values, inner = np.asarray(field.control_values()), np.asarray(field.cell_values())
    assert values.min() <= inner.min() < inner.max() <= values.max()
    # A face with a control at each corner would take their mean: here the nearest one leads.
    centres = ball().nodes[ball().faces[:, :3]].mean(1)
    nearest = np.linalg.norm(centres[:, None] - controls().points, axis=2).argmin(1)
    found = np.asarray(field.face_values())
    assert np.corrcoef(found, values[nearest])[0, 1] > 0.7


def test_patches_take_one_value_each() -> None:
    field = field_of("patchwise", HEADS["log"]).with_parameters(jnp.linspace(-1, 1, 9))
    values = np.asarray(field.control_values())
    assert len(np.unique(values)) == 9
    for found in (field.face_values(), field.cell_values()):
        assert set(np.asarray(found)) <= set(values)
    assert len(set(np.asarray(field.face_values()))) == 9


def test_parameters_round_trip() -> None:
    for kind in KINDS:
        field = field_of(kind, HEADS["log"])
        moved = jax.tree.map(lambda a: a + 0.3, field.parameters())
        again = field.with_parameters(moved)
        jax.tree.map(np.testing.assert_array_equal, again.parameters(), moved)
        back = again.with_parameters(field.parameters())
        np.testing.assert_array_equal(back.control_values(), field.control_values())


def test_frozen_controls_keep_every_bit_and_have_no_gradient() -> None:
    start = field_of("control_points", HEADS["log"])
    start = start.with_parameters(jnp.asarray(np.random.default_rng(1).normal(size=9)))
    frozen = np.arange(9) % 2 == 0
    field = freeze(start, frozen)
    moved = field.with_parameters(field.parameters() + 0.37)
    kept, now = np.asarray(start.control_values()), np.asarray(moved.control_values())
    np.testing.assert_array_equal(now[frozen], kept[frozen])
    assert (now[~frozen] != kept[~frozen]).all()

    def total(parameters: jax.Array) -> jax.Array:
        return jnp.sum(field.with_parameters(parameters).cell_values() ** 2)

    gradient = np.asarray(jax.grad(total)(field.parameters()))
    assert not gradient[frozen].any()
    assert gradient[~frozen].all()


@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("kind", KINDS)
def test_taylor_remainder(kind: str, head: str) -> None:
    field = field_of(kind, HEADS[head])
    weight = jnp.asarray(np.random.default_rng(2).normal(size=len(ball().cells)))

    @jax.jit
    def value(parameters) -> jax.Array:
        moved = field.with_parameters(parameters)
        return jnp.sum(weight * moved.cell_values()) + jnp.sum(moved.face_values() ** 2)

    start = field.parameters()
    make = np.random.default_rng(3)
    direction = jax.tree.map(lambda a: jnp.asarray(make.normal(size=a.shape)), start)
    _, forward = jax.jvp(value, (start,), (direction,))
    back = jax.grad(value)(start)
    reverse = sum(
        jnp.vdot(a, b)
        for a, b in zip(jax.tree.leaves(back), jax.tree.leaves(direction), strict=True)
    )
    np.testing.assert_allclose(forward, reverse, rtol=1e-10)
    rest = [
        abs(
            float(
                value(jax.tree.map(lambda a, b, s=s: a + s * b, start, direction))
                - value(start)
                - s * reverse
            )
        )
        for s in 0.1 * SHARES
    ]
    assert np.polyfit(np.log(SHARES), np.log(rest), 1)[0] > 1.9


def test_encoding_values() -> None:
    point = jnp.array([[0.5, -0.25, 1.0]])
    got = np.asarray(encode(point, 2))[0]
    p = np.array([0.5, -0.25, 1.0])
    expected = np.concatenate(
        [
            p,
            [np.sqrt(0.25 + 0.0625 + 1)],
            np.sin(np.pi * p),
            np.cos(np.pi * p),
            np.sin(2 * np.pi * p),
            np.cos(2 * np.pi * p),
        ]
    )
    np.testing.assert_allclose(got, expected, atol=1e-15)
    assert encode(jnp.zeros((5, 3)), 3).shape == (5, 4 + 6 * 3)


def test_network_repeats_with_its_seed_only() -> None:
    one, same, other = (
        network_field(CONDUCTIVITY, ball(), HEADS["log"], 1.0, controls(), seed=seed, width=8)
        for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(one.control_values(), same.control_values())
    assert float(jnp.abs(one.control_values() - other.control_values()).max()) > 1e-6
    points = np.asarray(one.points)
    assert points.min() >= -1 and points.max() <= 1


def test_quantities_state_symbol_unit_and_bounds() -> None:
    for name, quantity in QUANTITIES.items():
        assert quantity.name == name
        assert quantity.symbol and quantity.unit
        assert 0 < quantity.lower < quantity.upper
        expected = "faces" if "convection" in name or "emissivity" in name else "cells"
        assert quantity.place == expected

"""Heat through the surface: its short derivative against the long one, face by face."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import ball_mesh, promote
from thermo.physics import Discretisation, discretise
from thermo.physics._exchange import exchange, plain_exchange
from thermo.physics.effects import (
    AbstractSurfaceEffect,
    Contact,
    Convection,
    Heating,
    LaggedRadiation,
    PrescribedFlux,
    Radiation,
    Schedule,
)

MAKE = np.random.default_rng(0)


def body(order: int) -> Discretisation:
    mesh = ball_mesh(0.02, 2)
    return discretise(mesh if order == 1 else promote(mesh))


def effects(space: Discretisation) -> tuple[AbstractSurfaceEffect, ...]:
    faces = len(space.mesh.faces)
    level = jnp.asarray(MAKE.uniform(0.3, 0.9, faces))
    lamp = jnp.asarray(MAKE.uniform(size=np.shape(space.face_weight)))
    return (
        Convection(20 * level, 285.0),
        Contact(40 * level, 290.0),
        Radiation(level, 280.0),
        LaggedRadiation(0.5 * level, 281.0),
        Heating(jnp.asarray(3.0), lamp, Schedule(jnp.asarray(11.0))),
        PrescribedFlux(100 * level),
    )


@pytest.mark.parametrize("about", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_both_derivatives_agree(order: int, about: bool) -> None:
    space = body(order)
    given = effects(space)
    nodes = len(space.mesh.nodes)
    temperature, base, rise, way, turn, cover = (
        jnp.asarray(MAKE.uniform(low, high, nodes))
        for low, high in ((300, 320), (300, 320), (-1, 1), (-1, 1), (-1, 1), (-1, 1))
    )

    def load(function, of, at, near):  # noqa: ANN001, ANN202
        return function(space, of, 5.0, at, rise, near if about else None)

    point, change = (given, temperature, base), (given, way, turn)
    # As one program: the small operations of both would take long to compile one by one.
    short, long = (
        eqx.filter_jit(eqx.filter_jvp)(lambda *p, f=f: load(f, *p), point, change)
        for f in (exchange, plain_exchange)
    )
    for mine, theirs in zip(short, long, strict=True):
        scale = float(jnp.abs(theirs).max())
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12 * scale)
    back = [
        eqx.filter_jit(
            lambda f: jax.vjp(lambda *p: load(f, given, *p), temperature, base)[1](cover)
        )(f)
        for f in (exchange, plain_exchange)
    ]
    for mine, theirs in zip(*back, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12)


def test_a_batch_of_changes_shares_the_matrix() -> None:
    space = body(1)
    given = effects(space)
    temperature = jnp.asarray(MAKE.uniform(300, 320, len(space.mesh.nodes)))
    ways = jnp.asarray(MAKE.normal(size=(3, len(temperature))))

    @jax.jit
    def push(way: jax.Array) -> jax.Array:
        def load(at: jax.Array) -> jax.Array:
            return exchange(space, given, 5.0, at, None, None)

        return jax.jvp(load, (temperature,), (way,))[1]

    together = jax.vmap(push, in_axes=-1, out_axes=-1)(ways.T)
    for number, way in enumerate(ways):
        np.testing.assert_allclose(together[:, number], push(way), rtol=0, atol=1e-15)

"""Many tangents side by side: single precision must not show beside the solver's tolerance."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh, promote
from thermo.physics import (
    ConjugateGradient,
    ForwardOnly,
    Model,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics._conjugate_gradient import SINGLE
from thermo.physics.effects import Convection, Radiation
from thermo.physics.integrators import Sdirk2

SPACE = discretise(promote(box_mesh((0.03, 0.02, 0.01), (6, 4, 2))))
MATERIALS = {"poor": (0.2, 1.5e6), "good": (150.0, 2.4e6)}


def run(material: jax.Array, factors: jax.Array, rtol: float) -> jax.Array:
    """Frames of a cooling body; factors are of a wave of the conductivity, capacity, h and eps."""
    cells, faces = len(SPACE.mesh.cells), len(SPACE.mesh.faces)
    centre = SPACE.mesh.nodes[SPACE.mesh.cells[:, :4]].mean(1)
    wave = jnp.asarray(np.sin(centre @ np.array([300.0, 200.0, 500.0])))
    model = Model(
        SPACE,
        material[0] * (1 + factors[0] * wave),
        jnp.full(cells, material[1]) * (1 + factors[1]),
        surface=(
            Convection(jnp.full(faces, 8.0) * (1 + factors[2]), 270.0),
            Radiation(jnp.full(faces, 0.9) * (1 + factors[3]), 270.0),
        ),
    )
    return solve_heat(
        model,
        jnp.full(len(SPACE.mesh.nodes), 300.0),
        uniform_steps(np.arange(1.0, 21.0), 1.0),
        integrator=Sdirk2(),
        solver=ConjugateGradient(rtol=rtol),
        adjoint=ForwardOnly(),
    ).temperature


def test_what_each_step_is_given_may_not_change() -> None:
    def total(heats: jax.Array) -> jax.Array:
        return ForwardOnly().run(lambda held, heat: (held + heat, held), jnp.zeros(()), heats)[0]

    heats = jnp.arange(3.0)
    assert float(total(heats)) == 3.0
    with pytest.raises(NotImplementedError, match="the same for all tangents"):
        jax.jvp(total, (heats,), (heats,))


@partial(jax.jit, static_argnames="rtol")
def tangents(material: jax.Array, rtol: float) -> jax.Array:
    """Derivatives of all frames by the four factors, side by side."""

    def push(way: jax.Array) -> jax.Array:
        return jax.jvp(lambda f: run(material, f, rtol), (jnp.zeros(4),), (way,))[1]

    return jax.vmap(push)(jnp.eye(4))


@pytest.mark.parametrize("name", list(MATERIALS))
def test_single_precision_does_not_show_at_the_tolerance(name: str) -> None:
    material = jnp.array(MATERIALS[name])
    exact, double, single = (tangents(material, r) for r in (1e-13, 0.999 * SINGLE, SINGLE))
    size = jnp.linalg.norm(exact, axis=(1, 2))
    of_double, of_single = (
        jnp.linalg.norm(found - exact, axis=(1, 2)) / size for found in (double, single)
    )
    rounding = float(jnp.finfo(jnp.float32).eps)
    assert bool(jnp.all(of_single < 1.5 * of_double + 10 * rounding)), (of_single, of_double)
    # Another precision it is.
    assert bool(jnp.any(of_single != of_double))

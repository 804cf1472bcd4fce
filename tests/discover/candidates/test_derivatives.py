"""Slopes of the readings by strengths, where they are smooth: what they leave is a square."""

from __future__ import annotations

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import FRAMES, GRID, NODES, QUICKLY, SOLVER, at, bare, lit, steps_of, within

from thermo.discover import Candidate, Place
from thermo.discover.candidates import (
    AmbientDrift,
    AnisotropicConductivity,
    CameraEmissivity,
    Evaporation,
    HiddenSource,
    InDepthAbsorption,
    LocalConvection,
    MissingRadiation,
    SensorLag,
    SupportContact,
    Void,
)
from thermo.inverse._addition import extend, read_as
from thermo.physics import solve_heat

INSIDE, TOP = (0.013, 0.006, 0.003), (0.010, 0.006, 0.008)  # m
# Of each candidate the strength of which the slope is taken, and a change that is large.
STRENGTHS = {
    "radiation": (0.3, 0.3),
    "local_convection": (60.0, 50.0),
    "support_contact": (100.0, 80.0),
    "ambient_drift": (4.0, 4.0),
    "evaporation": (0.01, 0.01),
    "hidden_source": (0.2, 0.2),
    "in_depth_absorption": (0.3, 0.3),
    "anisotropic_conductivity": (0.5, 0.4),
    "void": (0.4, 0.3),
    "sensor_lag": (2.0, 1.5),
    "camera_emissivity": (0.1, 0.1),
}
NAMES = list(STRENGTHS)
# Of these the readings are a straight line in the strength.
STRAIGHT = ("camera_emissivity",)


def made(strength: jax.Array) -> tuple[Candidate, ...]:
    """All of them at work."""
    by = {name: strength[number : number + 1] for number, name in enumerate(NAMES)}
    aside = jnp.zeros(5)
    return (
        MissingRadiation(by["radiation"]),
        LocalConvection(by["local_convection"], at(TOP, 0.004)),
        SupportContact(
            jnp.concatenate([by["support_contact"], aside]), Place(None, jnp.full(6, 0.002))
        ),
        AmbientDrift(by["ambient_drift"], duration=jnp.asarray(FRAMES[-1], float)),
        Evaporation(by["evaporation"]),
        HiddenSource(by["hidden_source"], at(INSIDE, 0.003)),
        InDepthAbsorption(by["in_depth_absorption"], Place(None, jnp.asarray([0.002]))),
        AnisotropicConductivity(jnp.concatenate([by["anisotropic_conductivity"], aside[:2]])),
        Void(by["void"], within(INSIDE, 0.004)),
        SensorLag(by["sensor_lag"]),
        CameraEmissivity(by["camera_emissivity"]),
    )


@partial(jax.jit, compiler_options=QUICKLY)
def push(strength: jax.Array, way: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Readings [K] and their slope along a way of the strengths, by one program for all."""

    def readings(strength: jax.Array) -> jax.Array:
        candidates, under = made(strength), lit()
        model = extend(bare(under), under, candidates)
        first = under.start(len(NODES))
        body = solve_heat(model, first, GRID, integrator=steps_of(model), solver=SOLVER)
        pinned = jnp.zeros(len(NODES))
        return read_as(body.temperature, jnp.asarray(FRAMES), under, pinned, candidates)

    return jax.jvp(readings, (strength,), (way,))


@cache
def middle() -> jax.Array:
    return jnp.asarray([where for where, _ in STRENGTHS.values()])


def test_the_names_are_those_of_the_cards() -> None:
    assert [one.card.name for one in made(middle())] == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_slope_by_a_strength_leaves_a_square(name: str) -> None:
    number = NAMES.index(name)
    way = jnp.zeros(len(NAMES)).at[number].set(STRENGTHS[name][1])
    value, slope = push(middle(), way)
    size = float(jnp.linalg.norm(slope))
    assert size > 0.3, "in kelvin over all readings"
    shares = 0.5 ** np.arange(1, 5)
    rest = np.array(
        [
            float(jnp.linalg.norm(push(middle() + h * way, way)[0] - value - h * slope))
            for h in shares
        ]
    )
    if name in STRAIGHT:
        assert rest.max() < 1e-9 * size
        return
    assert rest[0] < 0.3 * size
    assert np.polyfit(np.log(shares), np.log(rest), 1)[0] > 1.9

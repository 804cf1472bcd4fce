"""Heat through the surface, and how it changes with the temperature of the nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics._discretisation import (
    Discretisation,
    on_faces,
    surface_load,
    surface_mass,
)
from thermo.physics._edge_product import edge_product
from thermo.physics._pattern import expand
from thermo.physics.effects._effect import AbstractSurfaceEffect, Time

Effects = tuple[AbstractSurfaceEffect, ...]
AtFaces = Float[Array, "faces points"]


def flux_of(effects: Effects, temperature: AtFaces, time: Time) -> AtFaces:
    """Flux of all effects into the body [W/m2] at surface temperatures [K] and a time [s]."""
    return jnp.asarray(sum(effect.flux(temperature, time) for effect in effects))


def slope_of(effects: Effects, temperature: AtFaces) -> AtFaces | None:
    """Their coefficient in the matrix [W/m2/K]; None where no flux depends on temperature."""
    slopes = [effect.slope(temperature) for effect in effects]
    known = [slope for slope in slopes if slope is not None]
    return jnp.asarray(sum(known)) if known else None


def _through(
    effects: Effects, time: Time, now: AtFaces, rise: AtFaces | None, about: AtFaces | None
) -> AtFaces:
    """Flux [W/m2], with what a rise [K] changes by the slope at `about`, or else as it is now."""
    flux = flux_of(effects, now, time)
    slope = None if rise is None else slope_of(effects, now if about is None else about)
    return flux if rise is None or slope is None else flux - slope * rise


def _by_nodes(
    space: Discretisation, slope: AtFaces, change: Float[Array, " nodes"]
) -> Float[Array, " nodes"]:
    """Load [W] of a flux that changes by `slope` [W/m2/K] times a change [K] of the nodes."""
    outer, inner = space.surface, space.pattern.inner
    diagonal, edges = surface_mass(space, slope)
    product = edge_product(outer, diagonal, edges, change[inner:], expand(outer, edges))
    return jnp.pad(product, (inner, 0))


def plain_exchange(
    space: Discretisation,
    effects: Effects,
    time: Time,
    temperature: Float[Array, " nodes"],
    rise: Float[Array, " nodes"] | None,
    about: Float[Array, " nodes"] | None,
) -> Float[Array, " nodes"]:
    """Nodal heat rate [W] through the surface, integral of (q(T) - slope(about) rise) N_i.

    Arguments:

    - `effects`: of any kind: derivatives go from face to face.
    - `temperature`: T, (nodes,) [K]; `rise`: (nodes,) [K] or None; `about`: (nodes,) [K], None
      for T.
    """
    now = on_faces(space, temperature)
    more, base = (None if x is None else on_faces(space, x) for x in (rise, about))
    return surface_load(space, _through(effects, time, now, more, base))


exchange = eqx.filter_custom_jvp(plain_exchange)
"""The same for effects of each of whose flux at a point depends on the temperature there alone.

Its derivative by the nodes is a matrix on the surface, which a batch of tangents shares. None is
taken by the rise.
"""


def _pointwise(function: Callable[[AtFaces], AtFaces], at: AtFaces) -> AtFaces:
    return jax.jvp(function, (at,), (jnp.ones_like(at),))[1]


@exchange.def_jvp
def _(primals: Any, tangents: Any) -> Any:
    space, effects, time, temperature, rise, about = primals
    _, of_effects, of_time, moved, _, turned = tangents
    now = on_faces(space, temperature)
    more, base = (None if x is None else on_faces(space, x) for x in (rise, about))
    terms = []
    if any(leaf is not None for leaf in jax.tree.leaves((of_effects, of_time))):
        _, change = eqx.filter_jvp(
            lambda e, t: _through(e, t, now, more, base), (effects, time), (of_effects, of_time)
        )
        terms.append(surface_load(space, change))
    if moved is not None:
        slope = _pointwise(lambda x: _through(effects, time, x, more, base), now)
        terms.append(_by_nodes(space, slope, moved))
    if turned is not None and base is not None:
        slope = _pointwise(lambda x: _through(effects, time, now, more, x), base)
        terms.append(_by_nodes(space, slope, turned))
    out = surface_load(space, _through(effects, time, now, more, base))
    return out, sum(terms) if terms else jnp.zeros_like(out)

"""Fields and candidates together as one point, its residual and the slopes of that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo.discover._candidate import Candidate
from thermo.inverse import Case, Objective, Parameters, case_temperatures, penalty, with_fields
from thermo.inverse import whiten as whiten_errors
from thermo.physics import AbstractAdjoint, ForwardOnly

FEW, WIDTH = 4, 12
"""Directions that share one pass through each run [1]: two programs serve any number of them."""

STRENGTHS = (4, 8, 32)
"""The same for strengths alone: the least of these that holds all of them, or the last [1]."""


@final
class Extended(eqx.Module):
    """A point: parameters of the fields [1], and candidates with their strengths and places."""

    fields: Parameters
    candidates: tuple[Candidate, ...]


@final
class Numbers(eqx.Module):
    """Where in the flattened point each leaf lies, laid out as the point itself."""

    at: Extended
    count: int = eqx.field(static=True)


def numbers(point: Extended) -> Numbers:
    """Number [1] of each entry of the flattened point."""
    flat, unravel = ravel_pytree(point)
    # Whole numbers below 2^53 are exact as floats.
    return Numbers(unravel(jnp.arange(len(flat), dtype=flat.dtype)), len(flat))


def moved(point: Extended, change: Float[np.ndarray, " entries"]) -> Extended:
    """The point with its flattened entries changed, each in its unit."""
    flat, unravel = ravel_pytree(point)
    return unravel(flat + jnp.asarray(change))


def _read(
    objective: Objective, point: Extended, case: Case, adjoint: AbstractAdjoint | None = None
) -> Float[Array, "frames samples"]:
    fields = with_fields(objective, point.fields)
    return case_temperatures(objective, fields, case, adjoint, point.candidates)


def _white(objective: Objective, point: Extended, case: Case) -> Float[Array, " values"]:
    apart = _read(objective, point, case, ForwardOnly()) - case.data
    return whiten_errors(case.errors, case.used, apart).ravel()


@eqx.filter_jit
def readings(objective: Objective, point: Extended) -> list[Float[Array, "runs frames samples"]]:
    """What is read of each group of runs [K]."""
    return [jax.lax.map(lambda one: _read(objective, point, one), case) for case in objective.cases]


@eqx.filter_jit
def _columns(
    objective: Objective, point: Extended, ways: Float[Array, "ways entries"]
) -> tuple[Float[Array, " values"], Float[Array, "values ways"]]:
    flat, unravel = ravel_pytree(point)

    def push(function):  # noqa: ANN001, ANN202
        return jax.vmap(lambda way: jax.jvp(function, (flat,), (way,)), out_axes=(None, 1))(ways)

    values, slopes = [], []
    for case in objective.cases:
        value, slope = jax.lax.map(
            lambda one: push(lambda at: _white(objective, unravel(at), one)), case
        )
        values.append(value.ravel())
        slopes.append(slope.reshape(-1, len(ways)))
    value, slope = push(lambda at: penalty(objective, unravel(at).fields))
    return jnp.concatenate([*values, value]), jnp.concatenate([*slopes, slope])


def columns(
    objective: Objective, point: Extended, ways: Float[np.ndarray, "ways entries"]
) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values ways"]]:
    """Whitened residual [1] of readings and priors, and its slopes along ways of the entries."""
    parts = []
    value = np.zeros(0)
    width = FEW if len(ways) <= FEW else WIDTH
    for begin in range(0, max(len(ways), 1), width):
        some = ways[begin : begin + width]
        filled = np.zeros((width, ways.shape[1]))
        filled[: len(some)] = some
        value, slope = _columns(objective, point, jnp.asarray(filled))
        parts.append(np.asarray(slope)[:, : len(some)])
    return np.asarray(value), np.concatenate(parts, 1)


@eqx.filter_jit
def _signatures(
    objective: Objective, point: Extended, ways: Float[Array, "ways strengths"]
) -> Float[Array, "values ways"]:
    flat, unravel = ravel_pytree([one.strength for one in point.candidates])

    def at(strengths: Float[Array, " strengths"]) -> Extended:
        pairs = zip(point.candidates, unravel(strengths), strict=True)
        return with_candidates(point, tuple(replace(one, strength=some) for one, some in pairs))

    def slopes(case: Case) -> Float[Array, "values ways"]:
        def along(way: Float[Array, " strengths"]) -> Float[Array, " values"]:
            return jax.jvp(lambda some: _white(objective, at(some), case), (flat,), (way,))[1]

        return jax.vmap(along, out_axes=1)(ways)

    parts = [jax.lax.map(slopes, case) for case in objective.cases]
    return jnp.concatenate([part.reshape(-1, len(ways)) for part in parts])


def signatures(
    objective: Objective, point: Extended, ways: Float[np.ndarray, "ways strengths"]
) -> Float[np.ndarray, "values ways"]:
    """Slopes of the whitened readings [1] along ways of all strengths, one after the other.

    Places stay where they are, so that their shapes are made once for all ways. Priors, which no
    strength moves, follow with zeros.
    """
    values = sum(np.size(case.used) for case in objective.cases)
    found = np.zeros((values + penalty(objective, point.fields).size, len(ways)))
    width = next((one for one in STRENGTHS if len(ways) <= one), STRENGTHS[-1])
    for begin in range(0, len(ways), width):
        some = ways[begin : begin + width]
        filled = np.zeros((width, ways.shape[1]))
        filled[: len(some)] = some
        slopes = np.asarray(_signatures(objective, point, jnp.asarray(filled)))
        found[:values, begin : begin + width] = slopes[:, : len(some)]
    return found


@eqx.filter_jit
def whitened(
    objective: Objective, apart: Sequence[Float[Array, "runs frames samples"]]
) -> Float[Array, " values"]:
    """Differences [K] of each group of runs as residuals of the readings [1]."""
    parts = [
        jax.vmap(whiten_errors)(case.errors, case.used, one).ravel()
        for case, one in zip(objective.cases, apart, strict=True)
    ]
    return jnp.concatenate(parts)


def with_candidates(point: Extended, candidates: tuple[Candidate, ...]) -> Extended:
    """The point with other candidates, its fields as they are [1]."""
    return replace(point, candidates=candidates)

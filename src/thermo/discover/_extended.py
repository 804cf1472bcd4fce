"""Fields and candidates together as one point, its residual and the slopes of that."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int

from thermo._compiled import program
from thermo.discover._at_rest import rest_residual
from thermo.discover._candidate import Candidate
from thermo.inverse import (
    Case,
    Objective,
    Parameters,
    at_once,
    case_temperatures,
    penalty,
    with_fields,
)
from thermo.inverse import whiten as whiten_errors
from thermo.physics import AbstractAdjoint, ForwardOnly

FEW, WIDTH = 4, 12
"""Directions that share one pass through each run [1]: two programs serve any number of them."""

STRENGTHS = (4, 8, 32)
"""The same for strengths alone: the least of these that holds all of them, or the last [1]."""

Columns = tuple[Float[Array, " values"], Float[Array, "values ways"]]
"""Values [1], and their slopes along each way."""

OneRun = tuple[Case, Int[Array, ""]]
"""Runs of one shape, and the row of one of them [1]."""


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


def readings(objective: Objective, point: Extended) -> list[Float[Array, "runs frames samples"]]:
    """What is read of each group of runs [K]."""
    alone, runs = _apart(objective)
    each = iter(at_once(lambda run: _readings(alone, point, *run), runs))
    return [jnp.stack([next(each) for _ in case.data]) for case in objective.cases]


def _apart(objective: Objective) -> tuple[Objective, list[OneRun]]:
    """What all runs share, and each run by itself: one after the other they need one core only."""
    runs = [(case, jnp.asarray(row)) for case in objective.cases for row in range(len(case.data))]
    return replace(objective, cases=(), sequence=()), runs


def _one(group: Case, row: Int[Array, ""]) -> Case:
    # Within a program, so that rows are not cut out again whenever it runs.
    return jax.tree.map(lambda leaf: leaf[row], group)


@program
def _readings(
    alone: Objective, point: Extended, group: Case, row: Int[Array, ""]
) -> Float[Array, "frames samples"]:
    return _read(alone, point, _one(group, row))


def _push(
    function: Callable[[Float[Array, " entries"]], Float[Array, " values"]],
    at: Float[Array, " entries"],
    ways: Float[Array, "ways entries"],
) -> Columns:
    return jax.vmap(lambda way: jax.jvp(function, (at,), (way,)), out_axes=(None, 1))(ways)


@program
def _columns(
    alone: Objective,
    point: Extended,
    group: Case,
    row: Int[Array, ""],
    ways: Float[Array, "ways entries"],
) -> Columns:
    flat, unravel = ravel_pytree(point)
    case = _one(group, row)
    return _push(lambda at: _white(alone, unravel(at), case), flat, ways)


@program
def _other_columns(
    objective: Objective, point: Extended, ways: Float[Array, "ways entries"]
) -> Columns:
    flat, unravel = ravel_pytree(point)
    return _push(lambda at: _others(objective, unravel(at)), flat, ways)


def _others(objective: Objective, point: Extended) -> Float[Array, " values"]:
    """The residual [1] of what is no reading of a run: of priors, and of the body at rest."""
    rest = rest_residual(objective.cases, point.candidates)
    return jnp.concatenate([penalty(objective, point.fields), rest])


def columns(
    objective: Objective, point: Extended, ways: Float[np.ndarray, "ways entries"]
) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values ways"]]:
    """Whitened residual [1] and its slopes along ways of the entries.

    Readings come first, then priors, then what the body reads at rest.
    """
    width = FEW if len(ways) <= FEW else WIDTH
    alone, runs = _apart(objective)
    chunks = _filled(ways, width)
    work = [(*run, chunk) for run in runs for chunk in chunks]
    each = iter(at_once(lambda one: _columns(alone, point, *one), work))
    values, slopes = [], []
    for parts in [
        *([next(each) for _ in chunks] for _ in runs),
        [_other_columns(objective, point, chunk) for chunk in chunks],
    ]:
        values.append(np.asarray(parts[0][0]))
        slopes.append(np.concatenate([np.asarray(slope) for _, slope in parts], 1))
    return np.concatenate(values), np.concatenate(slopes)[:, : len(ways)]


def _filled(ways: Float[np.ndarray, "ways entries"], width: int) -> list[Float[Array, "width _"]]:
    """Ways in chunks of one width, so that one program serves all; zeros fill the last one up."""
    filled = np.zeros((-(-len(ways) // width) * width, ways.shape[1]))
    filled[: len(ways)] = ways
    return [jnp.asarray(filled[begin : begin + width]) for begin in range(0, len(filled), width)]


@program
def _signatures(
    alone: Objective,
    point: Extended,
    group: Case,
    row: Int[Array, ""],
    ways: Float[Array, "ways strengths"],
) -> Float[Array, "values ways"]:
    flat, at = _by_strengths(point)
    case = _one(group, row)
    return _push(lambda some: _white(alone, at(some), case), flat, ways)[1]


@program
def _other_signatures(
    objective: Objective, point: Extended, ways: Float[Array, "ways strengths"]
) -> Float[Array, "values ways"]:
    flat, at = _by_strengths(point)
    return _push(lambda some: _others(objective, at(some)), flat, ways)[1]


def _by_strengths(
    point: Extended,
) -> tuple[Float[Array, " strengths"], Callable[[Float[Array, " strengths"]], Extended]]:
    """The strengths of a point, and the point with others, places as they are."""
    flat, unravel = ravel_pytree([one.strength for one in point.candidates])

    def at(strengths: Float[Array, " strengths"]) -> Extended:
        pairs = zip(point.candidates, unravel(strengths), strict=True)
        return with_candidates(point, tuple(replace(one, strength=some) for one, some in pairs))

    return flat, at


def signatures(
    objective: Objective, point: Extended, ways: Float[np.ndarray, "ways strengths"]
) -> Float[np.ndarray, "values ways"]:
    """Slopes of the whitened readings [1] along ways of all strengths, one after the other.

    Places stay where they are, so that their shapes are made once for all ways. Rows as of
    `columns`.
    """
    width = next((one for one in STRENGTHS if len(ways) <= one), STRENGTHS[-1])
    alone, runs = _apart(objective)
    chunks = _filled(ways, width)
    work = [(*run, chunk) for run in runs for chunk in chunks]
    each = iter(at_once(lambda one: np.asarray(_signatures(alone, point, *one)), work))
    slopes = [np.concatenate([next(each) for _ in chunks], 1) for _ in runs]
    others = [np.asarray(_other_signatures(objective, point, chunk)) for chunk in chunks]
    return np.concatenate([*slopes, np.concatenate(others, 1)])[:, : len(ways)]


@program
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

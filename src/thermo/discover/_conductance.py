"""What an effect on the surface takes from the body for each kelvin."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.discover._candidate import AbstractHeatCandidate, Candidate, Place
from thermo.discover._descent import Free
from thermo.discover._entries import Active, entry_of
from thermo.discover._extended import Extended, numbers
from thermo.discover._standing import Standing, has_places, take
from thermo.inverse import NORMAL, Objective, Parameters, case_model, with_fields
from thermo.physics.effects import Contact, Convection

_STAYS: Final = 1.2
"""Times a footprint of the least depth [1] from which one ten times as deep is another."""


def conductance_of(
    standing: Standing,
    active: Active,
    free: Free,
    covariance: Float[np.ndarray, "free free"],
) -> tuple[float, float] | None:
    """The integral of h over all of a place, and its standard deviation [W/K].

    None where an effect adds no h [W/m2/K]. As a rule readings tell it better than h in the middle
    of a place, whose edge is a guess.

    Arguments: `free`, `covariance`: the entries that were fitted, and of these over their scales.

    Source: Seber and Wild, Nonlinear Regression (1989), section 5.1, errors of a function of what
    was fitted, linearised.
    """
    point = standing.point
    value = taken_by(standing, active, point)
    if value is None:
        return None
    entry = entry_of(point, active)
    every = np.asarray(_slope(standing.bench.coarse, point, entry.kind, entry.part))
    slope = every[free.number] * free.scale
    return float(value), float(np.sqrt(slope @ covariance @ slope))


@program
def _slope(objective: Objective, point: Extended, kind: int, part: int) -> Float[Array, " entries"]:
    flat, unravel = ravel_pytree(point)

    def whole(flat: Float[Array, " entries"]) -> Float[Array, ""]:
        value = _taken(objective, point.fields, unravel(flat).candidates[kind], part)
        assert value is not None, "asked of an effect that takes heat"
        return value

    return jax.grad(whole)(flat)


def strength_between(
    standing: Standing,
    active: Active,
    free: Free,
    covariance: Float[np.ndarray, "free free"],
    taken: tuple[float, float],
) -> tuple[float, float] | None:
    """In which a strength [W/m2/K] lies whose footprint may be of the least depth there can be.

    On a side that is flat the footprint stays, and None is returned, as where the depth is known to
    be larger. On a round one it is a line, and readings tell alone how much is `taken` in all of it
    [W/K], between two ends: by little over a deep footprint, or by much on that line.

    Arguments: `free`, `covariance`: as for `conductance_of`.
    """
    kind, part = entry_of(standing.point, active).kind, active[1]
    every = standing.point.candidates
    candidate, place = every[kind], every[kind].place
    if not isinstance(place, Place) or place.centre is not None:
        return None
    at, strength = _number(standing.point, free, kind, part), float(candidate.strength[part])
    least, most = float(free.low[at]), float(free.high[at])
    known = NORMAL * np.sqrt(covariance[at, at]) * free.scale[at]
    if float(place.size[part]) - known > least or not strength > 0:
        return None

    def footprint(depth: float) -> float:
        deep = replace(candidate, place=Place(None, place.size.at[part].set(depth)))
        others = (*every[:kind], deep, *every[kind + 1 :])
        value = taken_by(standing, active, replace(standing.point, candidates=others))
        assert value is not None
        return float(value) / strength

    line = footprint(least)
    if footprint(10 * least) < _STAYS * line:
        return None
    return taken[0] / footprint(most), taken[1] / line


def _number(point: Extended, free: Free, kind: int, part: int) -> int:
    """Which of the free entries is the size of a place [1]."""
    where = numbers(point).at.candidates[kind].place
    assert where is not None, "asked of candidates with a place alone"
    return int(np.flatnonzero(free.number == int(where.size[part]))[0])


def taken_by(standing: Standing, active: Active, point: Extended) -> Float[Array, ""] | None:
    """The integral of h over all of the place of an effect at a point [W/K]."""
    entry = entry_of(standing.point, active)
    candidate = point.candidates[entry.kind]
    return _taken_now(standing.bench.coarse, standing.point.fields, candidate, entry.part)


def _taken(
    objective: Objective, fields: Parameters, candidate: Candidate, part: int
) -> Float[Array, ""] | None:
    alone = _alone(candidate, part)
    if not isinstance(alone, AbstractHeatCandidate):
        return None
    case = jax.tree.map(lambda leaf: leaf[0], objective.cases[0])
    model = case_model(objective, with_fields(objective, fields), case)
    added = alone.to_model(model, case.under).surface[len(model.surface) :]
    films = [jnp.asarray(_film(one)) for one in added if isinstance(one, Convection | Contact)]
    if not films:
        return None
    weight = objective.space.face_weight
    each = [jnp.sum(one.reshape(len(one), -1) * weight) for one in films]
    return jnp.sum(jnp.stack(each))


_taken_now = program(_taken)


def _alone(candidate: Candidate, part: int) -> Candidate:
    """A candidate of which one part is at work [SI]."""
    if has_places(candidate):
        return take(candidate, np.array([part]))
    if candidate.card.joint:
        return candidate
    alone = jnp.zeros_like(candidate.strength).at[part]
    return replace(candidate, strength=alone.set(candidate.strength[part]))


def _film(effect: Convection | Contact) -> Array | np.ndarray:
    return effect.coefficient if isinstance(effect, Convection) else effect.conductance

"""What the places of effects may make wrong: their shapes are guesses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from thermo.discover._allowance import Allowance, beside
from thermo.discover._bench import read_there, steps_for
from thermo.discover._candidate import Candidate, Inclusion, Transition, Where
from thermo.discover._conductance import taken_by
from thermo.discover._entries import Active, entry_of
from thermo.discover._extended import Extended, whitened
from thermo.discover._scores import ScoreTable, credible
from thermo.discover._skin import across_skin
from thermo.discover._standing import Standing, box_of, fitted, has_places, with_few_places

ELSEWHERE: Final = 0.15
"""As much of an effect may be elsewhere than its place says [1]."""

CLEAR: Final = 2.0
"""What passes the threshold so many times and is all over the body comes from no edge [1].

Logarithms of such scores in thresholds, where nothing else was to be found, had the mean -0.6 and
the deviation 0.4 in 16 recordings: twice the threshold is passed in 0.2 % then.
"""

# Sizes over the found one [1].
_SIZES: Final = (0.5, 2.0)
# How far an axis goes along the skin at the least where a patch is moved along it [1].
_ALONG: Final = 0.5
# Of what a patch takes in place, the least that it takes elsewhere as it is [1]: with less it lies
# beside the body.
_THERE: Final = 0.1

Corners = Float[np.ndarray, "2 3"]


def with_doubt(standing: Standing, allowed: Allowance) -> Standing:
    """Fitted anew, with `allowed` and what the shapes of places at work may make wrong beside it.

    Nature's places are not bells or boxes. Of each effect a share of 0.15 may be one size away
    along any axis, or be spread half or twice as wide, each by itself at random: what is read then,
    less what is read with all of it in place, is an error of known shape [1]. A patch with an edge
    stays in the skin, across which its place and its size mean nothing, and takes as much in all:
    off the skin a change of place would do what a change of its strength does.

    Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """
    small, _ = with_few_places(standing)
    corners = box_of(small)
    others = [one for active in small.active for one in _elsewhere(small, active, corners)]
    if not others:
        return undoubted(standing, allowed)
    objective = steps_for(small.bench.coarse, small.point)
    memory = small.bench.memory
    base = read_there(memory, objective, small.point)
    made = np.zeros((len(standing.ended.residual), len(others)))
    for number, point in enumerate(others):
        read = read_there(memory, objective, point)
        apart = [ELSEWHERE * (one - known) for one, known in zip(read, base, strict=True)]
        white = np.asarray(whitened(objective, apart))
        # A simulation that bursts elsewhere tells of no error.
        made[: len(white), number] = white if np.isfinite(white).all() else 0.0
    return fitted(replace(standing, allowed=beside(allowed, made)), times=0)


def clear_of_shapes(table: ScoreTable, kinds: Mapping[str, Candidate]) -> ScoreTable:
    """The scores of what is all over the body, if one is far too large for edges; else unfollowed.

    Where the smooth shapes that are left may come from a place's, so may scores somewhat beyond the
    threshold, as edges are finer than what is allowed for. What is all over the body they resemble
    less than another place beside them. `kinds`: candidates by name.
    """
    over_all = [one for one in table.scores if not _within(kinds[one.name()])]
    if any(credible(one, CLEAR * table.threshold) for one in over_all):
        return replace(table, scores=over_all)
    return replace(table, scores=[], unfollowed=over_all)


def _within(kind: Candidate) -> bool:
    """Whether its parts are at places in the body, and not all over it or at all of a side."""
    return has_places(kind) and not isinstance(kind.place, Transition)


def undoubted(standing: Standing, allowed: Allowance) -> Standing:
    """Fitted anew with `allowed` [1] alone, where it was not."""
    if standing.allowed is allowed:
        return standing
    return fitted(replace(standing, allowed=allowed), times=0)


def _elsewhere(standing: Standing, active: Active, corners: Corners) -> list[Extended]:
    """The point where a search stands, with an effect's place changed, one way each [1]."""
    point = standing.point
    entry = entry_of(point, active)
    kind, part = entry.kind, entry.part
    one = point.candidates[kind]
    if one.place is None:
        return []

    def instead(other: Candidate) -> Extended:
        return replace(
            point, candidates=(*point.candidates[:kind], other, *point.candidates[kind + 1 :])
        )

    whole = taken_by(standing, active, point)
    if whole is None or not isinstance(one.place, Inclusion):
        return [instead(replace(one, place=place)) for place in _places(one.place, part, corners)]
    along = 1 - across_skin(one.place, part, standing.bench.ready.mesh)
    moved = [replace(one, place=place) for place in _places(one.place, part, corners, along)]
    takes = [taken_by(standing, active, instead(other)) for other in moved]
    return [
        instead(replace(other, strength=other.strength.at[part].multiply(whole / there)))
        for other, there in zip(moved, takes, strict=True)
        if there is not None and float(there / whole) >= _THERE
    ]


def _places(
    place: Where, part: int, corners: Corners, along: Float[np.ndarray, "3"] | None = None
) -> list[Where]:
    """A place with one part of it wider, narrower or elsewhere in the body [m, or K].

    `along`: by how much an inclusion may be so along each axis, from 0 to 1 [1].
    """
    power = 1.0 if along is None else along
    made = [replace(place, size=place.size.at[part].multiply(by**power)) for by in _SIZES]
    centre = place.centre
    if centre is None:
        return made
    if isinstance(place, Transition):
        moved = [centre[part] + sign * place.size[part] for sign in (-1, 1)]
    else:
        ways = jnp.diag(jnp.broadcast_to(place.size[part], 3))
        ways = ways if along is None else ways[along > _ALONG]
        moved = [jnp.clip(centre[part] + sign * way, *corners) for way in ways for sign in (-1, 1)]
    return made + [replace(place, centre=centre.at[part].set(one)) for one in moved]

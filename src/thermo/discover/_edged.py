"""Places that end at an edge, where bells leave a misfit."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool

from thermo.discover._candidate import (
    SHARPNESS,
    SQUARENESS,
    Candidate,
    Inclusion,
    Place,
    with_edge,
)
from thermo.discover._misfit import chance_near
from thermo.discover._pace import Pace
from thermo.discover._rounds import effect_of, rms
from thermo.discover._skin import across_skin, flat_across, on_skin
from thermo.discover._standing import BY_SHAPES, Standing, fitted, lost, share_closed
from thermo.discover._verdict import Round
from thermo.mesh import Mesh

# Of a patch that is even, over one that fades as a bell, for as much in all [1]; across the skin it
# begins so thin, over how wide it is [1].
_EVEN, _FLAT = 0.5, 0.25

# A place with an edge is fitted anew so many times at the most [1].
_ANEW: Final = 6

_NEAR: Final = 3.0
"""Sizes of a bell within which readings tell its form [1]: a hundredth of it is left there."""


def with_an_edge(
    standing: Standing, rounds: list[Round], before: Standing, most: float, pace: Pace
) -> tuple[Standing, list[Round]]:
    """The last effect over a place that ends at an edge, if that explains more by `most` [1].

    A support, a fan's outline or a heater is no bell. It is tried where a bell leaves more than
    noise in smooth shapes, or at samples near it, until a place does not.

    Arguments: `before`: where the search stood without the effect; `most`: in squares.
    """
    name, part = standing.active[-1]
    kind = next(n for n, one in enumerate(standing.point.candidates) if one.card.name == name)
    bell = standing.point.candidates[kind]
    if with_edge(bell) is bell or not _misses(standing):
        return standing, rounds
    pace.step(f"trying {name} over a place that ends at an edge")
    every, best, mesh = list(standing.point.candidates), standing, standing.bench.ready.mesh
    for start in _starts(bell, part, mesh):
        every[kind] = start
        held = {one: _held(start, one[1], mesh) for one in standing.active if one[0] == name}
        point = replace(standing.point, candidates=tuple(every))
        there = replace(standing, point=point, held={**standing.held, **held})
        there = _settled(fitted(there, times=1), most)
        if not lost(there) and (best is standing or there.ended.loss() < best.ended.loss()):
            best = there
        if best is there and not _misses(there):
            break
    spread = min(standing.misfit(), best.misfit())
    gained = standing.ended.criterion(spread) - best.ended.criterion(spread)
    if not gained > most:
        return standing, rounds
    effect = effect_of(best, best.active[-1], best.misfit())
    closed = share_closed(before, best)
    last = replace(rounds[-1], effect=effect, rms_after=rms(best), closed=closed)
    return best, [*rounds[:-1], last]


def _settled(there: Standing, most: float) -> Standing:
    """Fitted anew while what is left changes by `most` or more [1], cells' errors measured anew.

    A place that has come far, or grown, is not what these were measured at.
    """
    for _ in range(0 if lost(there) else _ANEW):
        after = fitted(there, times=1)
        if lost(after):
            break
        apart = 2 * abs(after.ended.loss() - there.ended.loss())
        there = after
        if apart < most:
            break
    return there


def _starts(bell: Candidate, part: int, mesh: Mesh) -> tuple[Candidate, ...]:
    """Where candidates with an edge begin: a fit ends in the valley that it begins in [SI].

    A source as wide along each axis, or a patch on the side of the body that the bell lay at: that
    reaches through a thin wall to its other side, and such a patch does not. And what is as like
    the bell as it can be, first where a patch goes round an edge of the body: outlines that are
    sharp from the first hardly move across cells.
    """
    even = with_edge(bell)
    assert isinstance(even.place, Inclusion), "asked of bells alone"
    ones = jnp.ones_like(even.place.squareness)
    place = replace(even.place, squareness=SQUARENESS[1] * ones, sharpness=SHARPNESS[1] * ones)
    soft = replace(even, place=place)
    if bell.card.total:
        return even, soft
    less, thin = even.strength.at[part].multiply(_EVEN), on_one_side(bell, part, mesh)
    soft = replace(soft, strength=less)
    return (thin, soft) if _held(thin, part, mesh).any() else (soft, thin)


def _held(even: Candidate, part: int, mesh: Mesh) -> Bool[np.ndarray, "3"]:
    """Along which axes a patch stays as it begins: across a flat skin, as no reading tells these.

    Told once: one that comes to lie on a flat skin in a fit has been free all along.
    """
    place = even.place
    assert isinstance(place, Inclusion), "asked of what has an edge"
    return np.zeros(3, bool) if even.card.total else flat_across(place, part, mesh)


def _misses(standing: Standing) -> bool:
    """Whether the place of the last effect leaves a misfit in smooth shapes, or near by."""
    if standing.chance() <= BY_SHAPES:
        return True
    name, part = standing.active[-1]
    place = next(one.place for one in standing.point.candidates if one.card.name == name)
    assert isinstance(place, Place | Inclusion) and place.centre is not None, "asked of those alone"
    # A bell is half as wide as what is even and has its moments.
    half = 2.0 if isinstance(place, Inclusion) else 1.0
    centre, size = np.asarray(place.centre[part]), float(np.max(place.size[part])) / half
    near = {
        run.name: np.linalg.norm(run.recording.points - centre, axis=1) <= _NEAR * size
        for run in standing.bench.task.runs
    }
    return chance_near(standing.allowed.runs, standing.ended.residual, near) <= BY_SHAPES


def on_one_side(bell: Candidate, part: int, mesh: Mesh) -> Candidate:
    """A candidate with an edge, the part at work thin across the nearest face of a mesh [m].

    Its middle is on the skin there, if that is flat: its strength is that of the skin then.
    """
    even = with_edge(bell)
    assert isinstance(even.place, Inclusion), "asked of bells alone"
    thin = jnp.asarray(1 - (1 - _FLAT) * across_skin(even.place, part, mesh))
    place = replace(even.place, size=even.place.size.at[part].multiply(thin))
    middle = place.centre.at[part].set(jnp.asarray(on_skin(place, part, mesh)))
    strength = even.strength.at[part].multiply(_EVEN)
    return replace(even, strength=strength, place=replace(place, centre=middle))

"""Places that end at an edge, where bells leave a misfit."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import jax.numpy as jnp
import numpy as np

from thermo.discover._candidate import Candidate, Inclusion, Place, with_edge
from thermo.discover._misfit import chance_near
from thermo.discover._pace import Pace
from thermo.discover._rounds import effect_of, rms
from thermo.discover._skin import across_skin, on_skin
from thermo.discover._standing import BY_SHAPES, Standing, fitted, lost, share_closed
from thermo.discover._verdict import Round
from thermo.mesh import Mesh

# Of a patch that is even, over one that fades as a bell, for as much in all [1]; across the skin it
# begins so thin, over how wide it is [1].
_EVEN, _FLAT = 0.5, 0.25

_NEAR: Final = 3.0
"""Sizes of a bell within which readings tell its form [1]: a hundredth of it is left there."""


def with_an_edge(
    standing: Standing, rounds: list[Round], before: Standing, most: float, pace: Pace
) -> tuple[Standing, list[Round]]:
    """The last effect over a place that ends at an edge, if that explains more by `most` [1].

    A support, a fan's outline or a heater is no bell. It is tried where a bell leaves more than
    noise in smooth shapes, or at samples near it: a source as wide along each axis, a patch on the
    side of the body that the bell lay at: that reaches through a thin wall to its other side, and
    such a patch does not.

    Arguments: `before`: where the search stood without the effect; `most`: in squares.
    """
    name, part = standing.active[-1]
    kind = next(n for n, one in enumerate(standing.point.candidates) if one.card.name == name)
    bell = standing.point.candidates[kind]
    if with_edge(bell) is bell or not _misses(standing, bell, part):
        return standing, rounds
    pace.step(f"trying {name} over a place that ends at an edge")
    every = list(standing.point.candidates)
    mesh = standing.bench.ready.mesh
    every[kind] = with_edge(bell) if bell.card.total else on_one_side(bell, part, mesh)
    there = replace(standing, point=replace(standing.point, candidates=tuple(every)))
    there = fitted(there, times=1)
    spread = standing.misfit() if lost(there) else min(standing.misfit(), there.misfit())
    gained = standing.ended.criterion(spread) - there.ended.criterion(spread)
    if lost(there) or not gained > most:
        return standing, rounds
    effect = effect_of(there, there.active[-1], there.misfit())
    closed = share_closed(before, there)
    last = replace(rounds[-1], effect=effect, rms_after=rms(there), closed=closed)
    return there, [*rounds[:-1], last]


def _misses(standing: Standing, bell: Candidate, part: int) -> bool:
    """Whether the part of a bell at work leaves a misfit in smooth shapes, or near by."""
    if standing.chance() <= BY_SHAPES:
        return True
    place = bell.place
    assert isinstance(place, Place) and place.centre is not None, "asked of bells alone"
    centre, size = np.asarray(place.centre[part]), float(place.size[part])
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

"""All candidates scored where a search stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from thermo._compiled import make_room
from thermo.discover._bench import steps_for
from thermo.discover._candidate import Candidate
from thermo.discover._entries import Entry, entries
from thermo.discover._extended import Extended, signatures
from thermo.discover._projection import projection
from thermo.discover._scores import ScoreTable, score_table
from thermo.discover._standing import Standing, with_few_places
from thermo.inverse import at_once


def scored(standing: Standing, laws: tuple[Candidate, ...], *, alpha: float) -> ScoreTable:
    """The table of all candidates but those at work.

    Its threshold is as much higher as scores scatter more than by noise alone [1].
    """
    make_room()
    point = standing.point
    here = [one for one in entries(point) if (one.card.name, one.part) not in standing.active]
    beside, there = _law_entries(standing, laws)
    # Side by side, as each has a program of its own to compile; all there is may be at work.
    asked = [(at, some) for at, some in ((point, here), (beside, there)) if some]
    parts = [
        np.zeros((len(standing.ended.residual), 0)),
        *at_once(lambda one: _signatures(standing, *one), asked),
    ]
    table = score_table(
        [*here, *there], standing.allowed.whiten(np.concatenate(parts, 1)),
        standing.ended.residual, projection(standing.ended.slopes), alpha=alpha,
    )  # fmt: skip
    return replace(table, threshold=table.threshold * standing.bench.scatter)


def _law_entries(standing: Standing, laws: tuple[Candidate, ...]) -> tuple[Extended, list[Entry]]:
    """Entries of laws that the point does not hold yet, in a point that does.

    Of laws all transitions are scored, of what else has a place what is at work alone.
    """
    known = {one.card.name for one in standing.point.candidates}
    if all(one.card.name in known for one in laws):
        return standing.point, []
    few = with_few_places(standing)[0]
    beside = beside_laws(few, laws)
    return beside, [one for one in entries(beside) if one.card.name not in known]


def beside_laws(standing: Standing, laws: tuple[Candidate, ...]) -> Extended:
    """All kinds, laws among them: a program apart, as laws cost twice the iterations.

    The same one whatever is at work, so that it is compiled once.
    """
    return replace(standing.point, candidates=merged(standing.point.candidates, laws))


def merged(own: tuple[Candidate, ...], others: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """One's own, and what others have beside [1]."""
    names = {one.card.name for one in own}
    return (*own, *(one for one in others if one.card.name not in names))


def _signatures(
    standing: Standing, point: Extended, found: list[Entry]
) -> Float[np.ndarray, "values columns"]:
    """Slopes by the strengths of parts, each by its typical strength [1]."""
    every = np.concatenate([one.strengths for one in entries(point)])
    numbers = np.searchsorted(every, np.concatenate([one.strengths for one in found]))
    sizes = np.concatenate([np.full(len(e.strengths), e.card.typical) for e in found])
    ways = np.zeros((len(numbers), len(every)))
    ways[np.arange(len(numbers)), numbers] = sizes
    follows = steps_for(standing.bench.coarse, point), point, ways
    (slopes,) = standing.bench.memory.recalled("scores", follows, lambda: [signatures(*follows)])
    return slopes

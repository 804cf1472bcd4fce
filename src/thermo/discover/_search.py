"""One round of the search: score all candidates, refit the credible ones, compare them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Float, Int
from scipy.stats import chi2

from thermo._compiled import make_room
from thermo.discover._allowance import Allowance
from thermo.discover._bench import Bench, corrected, finer_runs, steps_for
from thermo.discover._candidate import Candidate
from thermo.discover._descent import Ended, Free, descend
from thermo.discover._entries import (
    Active,
    Entry,
    entries,
    entry_of,
    field_entries,
    free_entries,
    joined,
)
from thermo.discover._extended import Extended, moved, signatures
from thermo.discover._pace import MEASURE, REFIT, Pace
from thermo.discover._projection import projection
from thermo.discover._scores import Score, ScoreTable, best_of_kinds, credible, score_table
from thermo.discover._softening import omnibus

# Of a few kinds each is refitted whose score explains this share of what the best one does, and
# all whose score explains another share of it [1]: far from where scores are linear they rank
# kinds but roughly.
_FEW: Final = 6
_SHOWS: Final = 0.05
_ALL: Final = 0.5
# What a fit may gain over what its score promises [1]: where there is a place, it moves.
_MORE: Final = 5.0
_MORE_WITH_PLACE: Final = 10.0
# Kinds near the best of which what cells make wrong is measured anew [1].
_MEASURED: Final = 3
# Of what the best gains by the criterion, how far behind one may be to be measured anew [1].
_NEAR: Final = 0.3

WORTH: Final = 0.5
"""An effect has to close this share of what is left [1]."""

BY_SHAPES: Final = 0.01
"""Chance of a false alarm by the misfit in smooth shapes [1]."""

Parts = Int[np.ndarray, " parts"]


@final
@dataclass(frozen=True)
class Standing:
    """Where the search stands: a point, which parts of its candidates are at work, and the fit.

    - `first`: every candidate by name, its places where it is looked for at first.
    - `allowed`: what cells, steps, stamps and the stated model may be wrong by.
    """

    bench: Bench
    first: Mapping[str, Candidate]
    point: Extended
    active: tuple[Active, ...]
    ended: Ended
    allowed: Allowance

    def gap(self) -> tuple[float, int]:
        """Sum of squares in the smooth shapes, and how many there are [1]."""
        told, count, _ = omnibus(self.allowed.runs, self.ended.residual)
        return told, count

    def misfit(self) -> float:
        """Variance of what is left in the smooth shapes over that of noise, 1 at the least [1]."""
        told, count = self.gap()
        return max(1.0, told / count)

    def chance(self) -> float:
        """Probability of as large a misfit in smooth shapes by chance [1]."""
        told, count = self.gap()
        return float(chi2.sf(told, count))


def free_of(standing: Standing) -> Free:
    """Fields and the parts of candidates at work, free [1]."""
    point = standing.point
    parts = [
        free_entries(point, entry_of(point, one), standing.first[one[0]], box_of(standing))
        for one in standing.active
    ]
    first = standing.bench.first(()).fields
    return joined(field_entries(point, first), *parts)


def box_of(standing: Standing) -> Float[np.ndarray, "2 3"]:
    """The least and the largest coordinates of the body [m]."""
    nodes = standing.bench.ready.mesh.nodes
    return np.stack([nodes.min(0), nodes.max(0)])


def fitted(standing: Standing, *, times: int, rival: float = np.inf) -> Standing:
    """Least squares from where it stands; what cells make wrong is measured `times` before [1].

    One that will not reach the loss of a `rival` [1] is not followed to its end.

    Of effects with a place only those at work take part, and one of each other kind: all refits
    share one program, and it is as small as that allows.
    """
    make_room()
    small, kept = with_few_places(standing)
    free = free_of(small)
    for number in range(max(times, 1)):
        bench = small.bench
        if number < times:
            bench = corrected(bench, small.point, finer_runs(bench, small.point))
        small = replace(small, bench=bench)
        ended = _descended(small, free, rival)
        small = replace(small, point=ended.point, ended=ended)
    back = tuple(
        _put_back(one, few, kept[one.card.name])
        for one, few in zip(standing.point.candidates, small.point.candidates, strict=True)
    )
    point = replace(small.point, candidates=back)
    return replace(standing, bench=small.bench, point=point, ended=small.ended)


def _descended(standing: Standing, free: Free, rival: float) -> Ended:
    """Where least squares end [1], or ended before the search was interrupted."""
    coarse = steps_for(standing.bench.coarse, standing.point)
    follows = coarse, standing.point, free, standing.allowed, rival

    def anew() -> list[np.ndarray]:
        ended = descend(*follows)
        return [np.asarray(ravel_pytree(ended.point)[0]), ended.residual, ended.slopes]

    at, residual, slopes = standing.bench.memory.recalled("fit", follows, anew)
    _, unravel = ravel_pytree(standing.point)
    return Ended(unravel(jnp.asarray(at)), residual, slopes)


def without(standing: Standing, number: int) -> Standing:
    """The standing with one of its effects taken out, not fitted anew [1]."""
    name, part = standing.active[number]
    entry = entry_of(standing.point, (name, part))
    flat = np.asarray(ravel_pytree(standing.point)[0])
    change = np.zeros(len(flat))
    change[entry.strengths] = -flat[entry.strengths]
    active = tuple(one for one in standing.active if one != (name, part))
    return replace(standing, point=moved(standing.point, change), active=active)


def at_work(standing: Standing) -> tuple[Candidate, ...]:
    """The effects at work, of those with places no more parts than that [SI]."""
    small, _ = with_few_places(standing)
    names = {name for name, _ in standing.active}
    return tuple(one for one in small.point.candidates if one.card.name in names)


def with_few_places(standing: Standing) -> tuple[Standing, dict[str, Parts]]:
    """The standing with few parts of effects with a place, and which they are [1]."""
    kept: dict[str, Parts] = {}
    for one in standing.point.candidates:
        name = one.card.name
        busy = sorted(part for other, part in standing.active if other == name)
        kept[name] = np.array(busy or [0]) if _has_places(one) else np.arange(len(one.strength))
    candidates = tuple(_take(one, kept[one.card.name]) for one in standing.point.candidates)
    first = {
        name: _take(one, kept[name]) if name in kept else one
        for name, one in standing.first.items()
    }
    active = tuple(
        (
            name,
            int(np.searchsorted(kept[name], part)) if _has_places(standing.first[name]) else part,
        )
        for name, part in standing.active
    )
    point = replace(standing.point, candidates=candidates)
    return replace(standing, point=point, first=first, active=active), kept


def _has_places(one: Candidate) -> bool:
    return one.place is not None and one.place.centre is not None


def _take(one: Candidate, parts: Parts) -> Candidate:
    if not _has_places(one):
        return one
    place = jax.tree.map(lambda leaf: leaf[parts], one.place)
    return replace(one, strength=one.strength[parts], place=place)


def _put_back(one: Candidate, few: Candidate, parts: Parts) -> Candidate:
    if not _has_places(one):
        return few
    place = jax.tree.map(lambda all_, some: all_.at[parts].set(some), one.place, few.place)
    return replace(one, strength=one.strength.at[parts].set(few.strength), place=place)


def scored(standing: Standing, laws: tuple[Candidate, ...], *, alpha: float) -> ScoreTable:
    """The table of all candidates but those at work."""
    make_room()
    point = standing.point
    here = [one for one in entries(point) if (one.card.name, one.part) not in standing.active]
    beside, there = _law_entries(standing, laws)
    # All there is may be at work.
    parts = [np.zeros((len(standing.ended.residual), 0))] + [
        _signatures(standing, at, some) for at, some in ((point, here), (beside, there)) if some
    ]
    return score_table(
        [*here, *there], standing.allowed.whiten(np.concatenate(parts, 1)),
        standing.ended.residual, projection(standing.ended.slopes), alpha=alpha,
    )  # fmt: skip


def _law_entries(standing: Standing, laws: tuple[Candidate, ...]) -> tuple[Extended, list[Entry]]:
    """Entries of laws that the point does not hold yet, in a point that does.

    Of laws all transitions are scored, of what else has a place what is at work alone.
    """
    known = {one.card.name for one in standing.point.candidates}
    if all(one.card.name in known for one in laws):
        return standing.point, []
    few = with_few_places(standing)[0]
    beside = _beside_laws(few, laws)
    return beside, [one for one in entries(beside) if one.card.name not in known]


def _beside_laws(standing: Standing, laws: tuple[Candidate, ...]) -> Extended:
    """All kinds, laws among them: a program apart, as laws cost twice the iterations.

    The same one whatever is at work, so that it is compiled once.
    """
    return replace(standing.point, candidates=_joined(standing.point.candidates, laws))


def _joined(own: tuple[Candidate, ...], others: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
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


@final
@dataclass(frozen=True)
class Refit:
    """A candidate put to work: its score before, and where the fit stands with it."""

    score: Score
    standing: Standing

    def name(self) -> str:
        """Of the candidate."""
        return self.score.name()


def worth_a_refit(order: list[Score]) -> list[Score]:
    """Of the best parts of kinds, the best first, those that a fit could put first [1]."""
    shares = [(one.z / order[0].z) ** 2 for one in order]
    return [
        one
        for number, (one, share) in enumerate(zip(order, shares, strict=True))
        if share >= (_SHOWS if number < _FEW else _ALL)
    ]


def could_reach(score: Score, loss: float, rival: float, *, placed: bool) -> bool:
    """Whether a fit might get from a loss [1] to a rival's, going by its score.

    A score promises z^2 / 2, what a linear model gains by the strength; `placed`: it has a place.
    """
    more = _MORE_WITH_PLACE if placed else _MORE
    return loss - more * score.z**2 / 2 <= rival


def share_closed(before: Standing, after: Standing) -> float:
    """Share of what is beyond noise in the smooth shapes that is gone after, 1 at the most [1].

    A gap within the scatter of noise is no measure: that scatter is then.
    """
    (told, count), (rest, _) = before.gap(), after.gap()
    return min(1.0, float((told - rest) / max(told - count, np.sqrt(2 * count))))


def refits(
    standing: Standing, table: ScoreTable, laws: tuple[Candidate, ...], pace: Pace
) -> list[Refit]:
    """The credible candidates put to work one by one, the best first.

    A score ranks what has a place, in the body or on the scale of temperature, by where it was
    looked for at first. Where none of those with large scores closes enough and what is left is no
    noise, the others are tried as well.
    """
    order = best_of_kinds([one for one in table.scores if credible(one, table.threshold)])
    worth = worth_a_refit(order)
    made = _all_put_to_work(standing, worth, [], laws, pace)
    if made and not any(_explains(standing, one.standing) for one in made):
        tried = {one.name() for one in worth}
        rest = [one for one in order if one.name() not in tried]
        made = _all_put_to_work(standing, rest, made, laws, pace)
    return _measured_anew(standing, made, pace) if made else []


def _explains(before: Standing, after: Standing) -> bool:
    """Whether a fit closes enough of a gap for a search to go on from there, or leaves noise."""
    return share_closed(before, after) >= WORTH or after.chance() > BY_SHAPES


def _all_put_to_work(
    standing: Standing,
    worth: list[Score],
    made: list[Refit],
    laws: tuple[Candidate, ...],
    pace: Pace,
) -> list[Refit]:
    """Refits made already, and those of all scores that could reach the best of them."""
    made = list(made)
    for number, score in enumerate(worth, 1):
        rival = min((one.standing.ended.loss() for one in made), default=np.inf)
        placed = standing.first[score.name()].place is not None
        if not could_reach(score, standing.ended.loss(), rival, placed=placed):
            continue
        words = f"refitting {score.name()}, score {score.z:.1f}, {number} of {len(worth)}"
        # One at least is measured anew, and the best of them once more.
        pace.step(words, REFIT, {REFIT: len(worth) - number + 1, MEASURE: 2})
        made.append(_put_to_work(standing, score, laws, rival))
    return made


def _spread(made: list[Refit]) -> float:
    """What the closest of the refits leaves, counted as noise: its variance [1]."""
    return min(made, key=lambda one: one.standing.ended.loss()).standing.misfit()


def in_order(made: list[Refit]) -> list[Refit]:
    """Refits by Akaike's criterion, what the closest of them leaves counted as noise."""
    spread = _spread(made)
    return sorted(made, key=lambda one: one.standing.ended.criterion(spread))


def near_best(before: Ended, made: list[Refit]) -> list[Refit]:
    """Of refits in order the first, and those behind it by little of what it gains, a few."""
    spread = _spread(made)
    first = made[0].standing.ended.criterion(spread)
    most = first + _NEAR * max(before.criterion(spread) - first, 0.0)
    return [one for one in made if one.standing.ended.criterion(spread) <= most][:_MEASURED]


def _put_to_work(
    standing: Standing, score: Score, laws: tuple[Candidate, ...], rival: float
) -> Refit:
    # From strength zero the first step is the linear one, of fields and strength together.
    card, point = score.entry.card, standing.point
    if card.name not in {one.card.name for one in point.candidates}:
        point = _beside_laws(standing, laws)
    active = (*standing.active, (card.name, score.entry.part))
    there = replace(standing, point=point, active=active)
    return Refit(score, fitted(there, times=0, rival=rival))


def _once_more(one: Refit, pace: Pace, number: int, count: int) -> Refit:
    words = f"measuring the cells' error with {one.name()}, {number} of {count}"
    pace.step(words, MEASURE, {MEASURE: count - number + 1})
    return replace(one, standing=fitted(one.standing, times=1))


def in_place_of(standing: Standing, number: int, rival: Refit, most: float) -> Standing:
    """The standing with a rival at work in place of an effect, fitted anew [1].

    One that cannot come within `most` in squares [1] of where it stands is not followed to its end.
    """
    less = without(standing, number)
    name, part = rival.standing.active[-1]
    theirs = next(one for one in rival.standing.point.candidates if one.card.name == name)
    own = _joined(less.point.candidates, rival.standing.point.candidates)
    kept = tuple(theirs if one.card.name == name else one for one in own)
    active = tuple(
        (name, part) if place == number else one for place, one in enumerate(standing.active)
    )
    there = replace(less, point=replace(less.point, candidates=kept), active=active)
    # What was fitted less may leave more, for the criterion.
    worst = standing.ended.loss() + (most / 2 + standing.ended.fitted()) * standing.misfit()
    return fitted(there, times=0, rival=worst)


def on_same_cells(one: Refit, best: Refit) -> Refit:
    """A refit with what cells make wrong where the best one stands, if it leaves less with that.

    Where a place moves within its cells, their error goes up and down by more than rivals are
    apart: only under the same error, and from the same places, is it known how far these are.
    """
    number = len(best.standing.active) - 1
    same = replace(one, standing=in_place_of(best.standing, number, one, most=0.0))
    return min(one, same, key=lambda each: each.standing.ended.loss())


def _measured_anew(standing: Standing, made: list[Refit], pace: Pace) -> list[Refit]:
    """Those near the best, fitted once more with what cells make wrong where they stand."""
    made = in_order(made)
    near = near_best(standing.ended, made)
    count = len(near) + 1
    again = in_order([_once_more(one, pace, number, count) for number, one in enumerate(near, 1)])
    again[0] = _once_more(again[0], pace, count, count)
    # What leaves more than without it, once cells are measured where it stands, fits these alone.
    sound = [one for one in again if one.standing.ended.loss() < standing.ended.loss()]
    lost = [one for one in again if sound and all(one is not other for other in sound)]
    best, *rivals = in_order(sound or again)
    again = [best, *rivals]
    if rivals:
        pace.step("comparing those near the best under the same error of cells")
        first, *rivals = in_order([best, *(on_same_cells(one, best) for one in rivals)])
        # One that has passed the best is met by it there once more.
        again = [first, *(on_same_cells(one, first) if one is best else one for one in rivals)]
    others = [one for one in made if all(one is not other for other in near)]
    return in_order(again) + others + lost


def with_all(refit: Refit, before: Standing) -> Standing:
    """Where a refit stands, among all candidates that there were before it."""
    found = {one.card.name: one for one in refit.standing.point.candidates}
    kept = tuple(found.get(one.card.name, one) for one in before.point.candidates)
    every = _joined(kept, refit.standing.point.candidates)
    return replace(refit.standing, point=replace(refit.standing.point, candidates=every))

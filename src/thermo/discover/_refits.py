"""Candidates put to work one by one, and compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from jax.flatten_util import ravel_pytree

from thermo.discover._candidate import Candidate
from thermo.discover._descent import Ended
from thermo.discover._pace import MEASURE, REFIT, Pace
from thermo.discover._scores import Score, ScoreTable, best_of_kinds, credible
from thermo.discover._scoring import beside_laws, merged
from thermo.discover._standing import BY_SHAPES, WORTH, Standing, fitted, share_closed, without
from thermo.discover._trust_region import in_short_steps, kept_promise, remeasured

# Of a few kinds each is refitted whose score explains this share of what the best one does, and
# all whose score explains another share of it [1]: far from where scores are linear they rank
# kinds but roughly.
_FEW: Final = 6
_SHOWS: Final = 0.05
_ALL: Final = 0.5
# What a fit may gain over what its score promises [1]: where there is a place, it moves.
_MORE: Final = 5.0
_MORE_WITH_PLACE: Final = 10.0
# The same over that where no fit explains enough: scores are far from linear then.
_FAR: Final = 10.0
# Logarithm of how far a coefficient is drawn before fits begin where the scene puts it as well [1]:
# a factor of three, which a rough first guess is hardly wrong by.
_ASTRAY: Final = 1.1
# Kinds near the best of which what cells make wrong is measured anew [1].
_MEASURED: Final = 3
# Of what the best gains by the criterion, how far behind one may be to be measured anew [1].
_NEAR: Final = 0.3


@final
@dataclass(frozen=True)
class Refit:
    """A candidate put to work: its score before, and where the fit stands with it.

    `begun`: where its fit began, at strength zero.
    """

    score: Score
    standing: Standing
    begun: Standing

    def name(self) -> str:
        """Of the candidate."""
        return self.score.name()


def refits(
    standing: Standing, table: ScoreTable, laws: tuple[Candidate, ...], pace: Pace
) -> list[Refit]:
    """The credible candidates put to work one by one, the best first.

    A score ranks what has a place, in the body or on the scale of temperature, by where it was
    looked for at first. Where none of those with large scores closes enough and what is left is no
    noise, the others are tried as well; not beside what was found, where little is left, scores
    are nearly linear, and whatever is free enough would take up the rest of another effect.
    """
    order = best_of_kinds([one for one in table.scores if credible(one, table.threshold)])
    worth = worth_a_refit(order)
    made = _all_put_to_work(standing, worth, [], laws, pace)
    if made and not standing.active and not any(_explains(standing, one.standing) for one in made):
        tried = {one.name() for one in made}
        rest = [one for one in order if one.name() not in tried]
        made = _all_put_to_work(standing, rest, made, laws, pace, far=_FAR)
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
    far: float = 1.0,
) -> list[Refit]:
    """Refits made already, and those of all scores that could reach the best of them.

    `far`: how many times more they may gain than where scores are nearly linear [1].
    """
    made = list(made)
    for number, score in enumerate(worth, 1):
        rival = _least_left(made)
        placed = standing.first[score.name()].place is not None
        if not could_reach(score, standing.ended.loss(), rival, placed=placed, far=far):
            continue
        words = f"refitting {score.name()}, score {score.z:.1f}, {number} of {len(worth)}"
        # One at least is measured anew, and the best of them once more.
        pace.step(words, REFIT, {REFIT: len(worth) - number + 1, MEASURE: 2})
        made.append(_put_to_work(standing, score, laws, rival))
    return made


def worth_a_refit(order: list[Score]) -> list[Score]:
    """Of the best parts of kinds, the best first, those that a fit could put first [1]."""
    shares = [(one.z / order[0].z) ** 2 for one in order]
    return [
        one
        for number, (one, share) in enumerate(zip(order, shares, strict=True))
        if share >= (_SHOWS if number < _FEW else _ALL)
    ]


def could_reach(score: Score, loss: float, rival: float, *, placed: bool, far: float = 1.0) -> bool:
    """Whether a fit might get from a loss [1] to a rival's, going by its score.

    A score promises z^2 / 2, what a linear model gains by the strength; `placed`: it has a place;
    `far`: as for `_all_put_to_work` [1].
    """
    more = far * (_MORE_WITH_PLACE if placed else _MORE)
    return loss - more * score.z**2 / 2 <= rival


def _put_to_work(
    standing: Standing, score: Score, laws: tuple[Candidate, ...], rival: float
) -> Refit:
    # From strength zero the first step is the linear one, of fields and strength together.
    card, point = score.entry.card, standing.point
    if card.name not in {one.card.name for one in point.candidates}:
        point = beside_laws(standing, laws)
    active = (*standing.active, (card.name, score.entry.part))
    there = replace(standing, point=point, active=active)
    made = Refit(score, fitted(there, times=0, rival=rival), there)
    if not far_from_first(standing):
        return made
    again = replace(there, point=replace(point, fields=standing.bench.first(()).fields))
    rival = min(rival, made.standing.ended.loss())
    other = Refit(score, fitted(again, times=0, rival=rival), again)
    return min(made, other, key=lambda one: one.standing.ended.loss())


def far_from_first(standing: Standing) -> bool:
    """Whether what is missing has drawn a coefficient far from where the scene puts it.

    A fit that begins there may end in another valley than one that begins where the scene says.
    """
    first, here = (
        np.asarray(ravel_pytree(fields)[0])
        for fields in (standing.bench.first(()).fields, standing.point.fields)
    )
    return bool(np.any(np.abs(here - first) > _ASTRAY))


def _once_more(one: Refit, rival: float, pace: Pace, number: int, count: int) -> Refit:
    """Fitted with what cells make wrong measured where it stands, or from its beginning.

    What leaves far more there than it seemed to was led astray by what they make wrong. One that
    will not reach the loss of a `rival` [1] is not followed to its end.
    """
    words = f"measuring the cells' error with {one.name()}, {number} of {count}"
    pace.step(words, MEASURE, {MEASURE: count - number + 1})
    there = remeasured(one.standing)
    if kept_promise(one.begun, one.standing, there):
        return replace(one, standing=fitted(there, times=0, rival=rival))
    pace.step(f"following {one.name()} in short steps, as cells are coarse for it")
    return replace(one, standing=in_short_steps(one.begun, rival))


def _measured_anew(standing: Standing, made: list[Refit], pace: Pace) -> list[Refit]:
    """Those near the best, fitted once more with what cells make wrong where they stand."""
    made = in_order(made)
    near = near_best(standing.ended, made)
    count, again = len(near) + 1, []
    for number, one in enumerate(near, 1):
        again.append(_once_more(one, _least_left(again), pace, number, count))
    best, *rivals = in_order(again)
    again = [_once_more(best, _least_left(rivals), pace, count, count), *rivals]
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


def _least_left(made: list[Refit]) -> float:
    """The least loss of refits [1], infinite where there are none."""
    return min((one.standing.ended.loss() for one in made), default=np.inf)


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


def in_place_of(standing: Standing, number: int, rival: Refit, most: float) -> Standing:
    """The standing with a rival at work in place of an effect, fitted anew [1].

    One that cannot come within `most` in squares [1] of where it stands is not followed to its end.
    """
    less = without(standing, number)
    name, part = rival.standing.active[-1]
    theirs = next(one for one in rival.standing.point.candidates if one.card.name == name)
    own = merged(less.point.candidates, rival.standing.point.candidates)
    kept = tuple(theirs if one.card.name == name else one for one in own)
    active = tuple(
        (name, part) if place == number else one for place, one in enumerate(standing.active)
    )
    there = replace(less, point=replace(less.point, candidates=kept), active=active)
    return fitted(there, times=0, rival=within(standing, most))


def within(standing: Standing, most: float) -> float:
    """The loss [1] of what comes within `most` in squares [1] of where a search stands.

    What was fitted less may leave more, for the criterion.
    """
    return standing.ended.loss() + (most / 2 + standing.ended.fitted()) * standing.misfit()


def on_same_cells(one: Refit, best: Refit) -> Refit:
    """A refit with what cells make wrong where the best one stands, if it leaves less with that.

    Where a place moves within its cells, their error goes up and down by more than rivals are
    apart: only under the same error, and from the same places, is it known how far these are.
    """
    number = len(best.standing.active) - 1
    same = replace(one, standing=in_place_of(best.standing, number, one, most=0.0))
    return min(one, same, key=lambda each: each.standing.ended.loss())


def with_all(refit: Refit, before: Standing) -> Standing:
    """Where a refit stands, among all candidates that there were before it."""
    found = {one.card.name: one for one in refit.standing.point.candidates}
    kept = tuple(found.get(one.card.name, one) for one in before.point.candidates)
    every = merged(kept, refit.standing.point.candidates)
    return replace(refit.standing, point=replace(refit.standing.point, candidates=every))

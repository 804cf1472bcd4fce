"""Whether a rival of an earlier effect does as well beside those that came later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import jax.numpy as jnp
import numpy as np

from thermo.discover._candidate import Transition
from thermo.discover._entries import Active
from thermo.discover._pace import Pace
from thermo.discover._refits import Refit, in_place_of, near_best, within
from thermo.discover._rounds import alternative_of, behind, effect_of, with_set
from thermo.discover._standing import WORTH, Standing, fitted, without
from thermo.discover._verdict import Round

# Share of a place's full strength that is within it [1].
_NEAR: Final = float(np.exp(-1))

Rivals = Mapping[Active, Sequence[Refit]]
"""By what was put to work, the refits of its round that came near it."""


def rivals_of(made: Sequence[Refit], before: Standing, also: Sequence[str] = ()) -> Rivals:
    """Effects that came near the first of a round's refits, `before` it was put to work.

    `also`: kinds that are rivals however near they came.
    """
    near = [id(one) for one in near_best(before.ended, list(made))]
    others = [
        one
        for one in made
        if (id(one) in near or one.name() in also)
        and one is not made[0]
        and not one.score.entry.card.fault
    ]
    return {made[0].standing.active[-1]: others}


def replaced(
    standing: Standing, rounds: list[Round], rivals: Rivals, most: float, pace: Pace
) -> tuple[Standing, list[Round], list[str]]:
    """Earlier effects by turns given up for each of their rivals; and what there is to say of it.

    They were told apart while a later effect was still missing, and what that left is no noise. So
    a rival takes the place of the first where the criterion falls by `most` [1], and stays beside
    it where it rises by less. Nothing is excluded here that a round had not excluded, but where
    that round closed less than `WORTH`: with most of the gap still there it told nothing apart.

    Source: Miller, Subset Selection in Regression (2002), chapter 3, sequential replacement.
    """
    rounds, remarks = list(rounds), []
    for number in range(len(rounds) - 1):
        others = rivals.get(standing.active[number], ())
        again = tentative(rounds[number]) and any(_is_at_work(standing, one) for one in others)
        needed = again and _needed(standing, number, most, pace)
        for rival in others:
            before, name = rounds[number], rounds[number].effect.card.name
            if rival.name() in {kind for kind, _ in standing.active}:
                if needed and _is_at_work(standing, rival):
                    rounds[number] = _less(before, rival.name())
                continue
            pace.step(f"trying {rival.name()} in place of {name}")
            there, spread = in_place_of(standing, number, rival, most), standing.misfit()
            by_criterion, by_loss = behind(there.ended, standing.ended, spread)
            if by_criterion < -most:
                standing = there
                effect = effect_of(there, there.active[number], spread)
                left = [one for one in before.together if one not in (name, rival.name())]
                rounds[number] = with_set(replace(before, effect=effect), [rival.name(), *left])
                remarks.append(f"{rival.name()} took the place of {name} beside what came later.")
            elif min(by_criterion, by_loss) < most:
                other = alternative_of(there, there.active[number], spread)
                kept = dict.fromkeys([*before.together, rival.name()])
                rounds[number] = with_set(before, list(kept), other)
            elif tentative(before):
                rounds[number] = _less(before, rival.name())
    return standing, rounds, remarks


def tentative(one: Round) -> bool:
    """Whether a round closed so little that only later ones tell if it was right."""
    return one.closed < WORTH


def _less(one: Round, name: str) -> Round:
    return with_set(one, [each for each in one.together if each != name])


def _needed(standing: Standing, number: int, most: float, pace: Pace) -> bool:
    """Whether the others at work do not do without an effect, by `most` in squares [1]."""
    pace.step(f"trying without {standing.active[number][0]}")
    less = fitted(without(standing, number), times=0, rival=within(standing, most))
    return min(behind(less.ended, standing.ended, standing.misfit())) >= most


def _is_at_work(standing: Standing, rival: Refit) -> bool:
    """Whether a rival is an effect at work, where it has a place, at the same."""
    name, part = rival.standing.active[-1]
    parts = [its for other, its in standing.active if other == name]
    if not parts:
        return False
    own, theirs = (
        next(one.place for one in each.point.candidates if one.card.name == name)
        for each in (standing, rival.standing)
    )
    if own is None or theirs is None or own.centre is None or theirs.centre is None:
        return True
    there = theirs.centre[part]
    if isinstance(own, Transition):
        near = jnp.exp(-jnp.abs(own.centre - there) / own.size)
    else:
        near = own.shapes(there)
    return bool(np.any(np.asarray(near)[parts] >= _NEAR))

"""Whether a rival of an earlier effect does as well beside those that came later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from thermo.discover._entries import Active
from thermo.discover._pace import Pace
from thermo.discover._refits import Refit, in_place_of, near_best
from thermo.discover._rounds import behind, effect_of
from thermo.discover._standing import Standing
from thermo.discover._verdict import Round

Rivals = Mapping[Active, Sequence[Refit]]
"""By what was put to work, the refits of its round that came near it."""


def rivals_of(made: Sequence[Refit], before: Standing) -> Rivals:
    """Effects that came near the first of a round's refits, `before` it was put to work."""
    near = near_best(before.ended, list(made))
    others = [one for one in near if one is not made[0] and not one.score.entry.card.fault]
    return {made[0].standing.active[-1]: others}


def replaced(
    standing: Standing, rounds: list[Round], rivals: Rivals, most: float, pace: Pace
) -> tuple[Standing, list[Round], list[str]]:
    """Earlier effects by turns given up for each of their rivals; and what there is to say of it.

    They were told apart while a later effect was still missing, and what that left is no noise. So
    a rival takes the place of the first where the criterion falls by `most` [1], and stays beside
    it where it rises by less. Nothing is excluded here that a round had not excluded.

    Source: Miller, Subset Selection in Regression (2002), chapter 3, sequential replacement.
    """
    rounds, remarks = list(rounds), []
    for number in range(len(rounds) - 1):
        for rival in rivals.get(standing.active[number], ()):
            if rival.name() in {name for name, _ in standing.active}:
                continue
            before, name = rounds[number], rounds[number].effect.card.name
            pace.step(f"trying {rival.name()} in place of {name}")
            there, spread = in_place_of(standing, number, rival, most), standing.misfit()
            by_criterion, by_loss = behind(there.ended, standing.ended, spread)
            if by_criterion < -most:
                standing = there
                effect = effect_of(there, there.active[number], spread)
                others = [one for one in before.together if one not in (name, rival.name())]
                rounds[number] = replace(before, effect=effect, together=[rival.name(), *others])
                remarks.append(f"{rival.name()} took the place of {name} beside what came later.")
            elif min(by_criterion, by_loss) < most and rival.name() not in before.together:
                rounds[number] = replace(before, together=[*before.together, rival.name()])
    return standing, rounds, remarks

"""The rounds of a search, one effect more in each, and the rule by which it stops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

from scipy.stats import chi2

from thermo.discover._calibration import Calibration, calibration
from thermo.discover._candidate import Candidate
from thermo.discover._projection import projection
from thermo.discover._rounds import (
    effect_of,
    effects_first,
    make_round,
    share_closed,
    with_joint_effects,
)
from thermo.discover._scores import ScoreTable, credible
from thermo.discover._search import Say, Standing, fitted, refits, scored, with_all, without
from thermo.discover._verdict import Effect, Round, Word

# Chance of a false alarm by the largest score, and by the misfit in smooth shapes [1]; each round
# has half of the one before.
_BY_SCORE: Final = 0.04
_BY_SHAPES: Final = 0.01
_ROUNDS: Final = 3
# Named effects close this share of what is beyond noise, or leave no more than noise [1].
_CLOSED: Final = 0.9
# An effect has to close this share of what is left [1].
_WORTH: Final = 0.5
# An effect may as well be absent where scatter gives strengths as large with this chance [1].
_ABSENT: Final = 0.05
# What an effect's place is like is a guess: 15 % of its amplitude may be left by that, squared [1].
_SHAPE: Final = 0.02


@final
@dataclass(frozen=True)
class SearchPath:
    """How far a search went.

    - `table`: the scores before anything was put to work; `calibrated`: its alarms by simulation.
    """

    word: Word
    rounds: list[Round]
    standing: Standing
    table: ScoreTable
    remarks: list[str]
    calibrated: Calibration


def search(begun: Standing, laws: tuple[Candidate, ...], say: Say) -> SearchPath:
    """Put effects to work one after the other until nothing is missing, or nothing explains it."""
    standing, rounds, remarks, quiet = begun, [], [], False
    tables: list[ScoreTable] = []
    for number in range(_ROUNDS):
        say(f"scoring all candidates, round {number + 1}")
        share = 0.5**number
        table = scored(standing, laws, alpha=share * _BY_SCORE)
        tables.append(table)
        calm = by_shapes(standing) > share * _BY_SHAPES
        if not _alarm(table) and calm:
            break
        if rounds and _is_shape(begun, standing):
            remarks.append(
                "What is left is less than 2 % of the gap: the shape of an effect's place is a "
                "guess and may leave as much, so that no more is read into it."
            )
            break
        made = effects_first(refits(standing, table, laws, say), table.threshold**2)
        one = make_round(standing, made, table) if made else None
        if calm and one is not None and one.effect.chance > _ABSENT:
            remarks.append(_nothing(one))
            quiet = not rounds
            break
        if one is not None and one.effect.card.fault:
            remarks.append(_fault(one.effect))
            break
        if rounds and (one is None or one.closed < _WORTH):
            remarks.append(_rest(one))
            break
        if one is None:
            break
        rounds.append(one)
        standing = with_all(made[0], standing)
        standing, rounds = pruned(standing, rounds, table.threshold**2, say, remarks)
        if one.closed < _WORTH:
            break
    word = "no_gap" if quiet else _word(begun, standing, rounds, tables[0])
    together = with_joint_effects(rounds, standing)
    return SearchPath(word, together, standing, tables[0], remarks, calibrated(begun, tables[0]))


def calibrated(begun: Standing, table: ScoreTable) -> Calibration:
    """How often the stated model's alarm would be false, by simulation [1]."""
    free, runs = projection(begun.ended.slopes), begun.allowed.runs
    return calibration(table, free, runs, shapes=_BY_SHAPES)


def pruned(
    standing: Standing, rounds: list[Round], most: float, say: Say, remarks: list[str]
) -> tuple[Standing, list[Round]]:
    """Without effects that those after them have made needless.

    One whose strengths may as well be zero beside the others is taken out, where the criterion
    rises by less than `most` [1] without it.

    Source: Efroymson, in Mathematical Methods for Digital Computers (1960), stepwise regression.
    """
    spread = standing.misfit()
    for number, active in enumerate(standing.active):
        effect = effect_of(standing, active, spread)
        if len(rounds) < 2 or effect.chance <= _ABSENT:
            continue
        say(f"trying without {effect.card.name}")
        less = fitted(without(standing, number), times=1)
        if less.ended.criterion(spread) - standing.ended.criterion(spread) < most:
            remarks.append(f"{effect.card.name} was tried, and is not needed beside the others.")
            return less, rounds[:number] + rounds[number + 1 :]
    return standing, rounds


def _nothing(one: Round) -> str:
    low, high = one.effect.interval95
    return (
        f"The score of {one.effect.card.name} passes the threshold, but fitted it is "
        f"{one.effect.strength:.3g} [{low:.3g}, {high:.3g}] {one.effect.card.unit}, which may be "
        "nothing, and nothing else is left."
    )


def _fault(found: Effect) -> str:
    return (
        f"What is left is met best by a fault of the record, {found.card.name} of "
        f"{found.strength:.3g} {found.card.unit}, which is not an effect on the body. What would "
        f"show it: {found.card.split_by}."
    )


def _rest(one: Round | None) -> str:
    if one is None:
        return "A rest is left that no candidate shows in."
    name = one.effect.card.name
    return (
        f"A rest is left that no candidate explains; the closest is {name}, "
        f"which closes {100 * max(one.closed, 0.0):.0f} % of it."
    )


def _word(begun: Standing, last: Standing, rounds: list[Round], table: ScoreTable) -> Word:
    if not rounds:
        gap = _alarm(table) or by_shapes(begun) <= _BY_SHAPES
        return "none_of_mine" if gap else "no_gap"
    if share_closed(begun, last) < _CLOSED and by_shapes(last) <= _BY_SHAPES:
        return "none_of_mine"
    return "named" if all(len(one.together) == 1 for one in rounds) else "inseparable"


def _alarm(table: ScoreTable) -> bool:
    return any(credible(one, table.threshold) for one in table.scores)


def by_shapes(standing: Standing) -> float:
    """Probability of as large a misfit in smooth shapes by chance [1]."""
    told, count = standing.gap()
    return float(chi2.sf(told, count))


def _is_shape(begun: Standing, standing: Standing) -> bool:
    """Whether what is left may be due to the shape of the places at work."""
    if all(standing.first[name].place is None for name, _ in standing.active):
        return False
    (told, count), (rest, _) = begun.gap(), standing.gap()
    return rest - count < _SHAPE * (told - count)

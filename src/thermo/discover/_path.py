"""The rounds of a search, one effect more in each, and the rule by which it stops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from thermo.discover._bench import FINEST, edge_of, finest
from thermo.discover._calibration import Calibration, calibration
from thermo.discover._candidate import Candidate
from thermo.discover._edged import with_an_edge
from thermo.discover._entries import Active
from thermo.discover._fine_slopes import by_fine_slopes
from thermo.discover._pace import Pace
from thermo.discover._place_doubt import (
    CLEAR,
    ELSEWHERE,
    clear_of_shapes,
    undoubted,
    with_doubt,
)
from thermo.discover._projection import projection
from thermo.discover._refits import Refit, refits, with_all
from thermo.discover._replacement import replaced, rivals_of, tentative
from thermo.discover._rounds import (
    effect_of,
    make_round,
    simplest_first,
    with_joint_effects,
)
from thermo.discover._scores import ScoreTable, best_of_kinds, credible
from thermo.discover._scoring import scored
from thermo.discover._small_cells import on_small_cells, placed, thinnest
from thermo.discover._standing import (
    BY_SHAPES,
    WORTH,
    Standing,
    fitted,
    lost,
    refined,
    share_closed,
    without,
)
from thermo.discover._verdict import Effect, Round, Word
from thermo.inverse import FINER

CLOSED: Final = 0.9
"""Named effects close this share of what is beyond noise, or leave no more than noise [1]."""

# Chance of a false alarm by the largest score [1]. Each round has half of the one before, of this
# and of that by smooth shapes.
_BY_SCORE: Final = 0.04
_ROUNDS: Final = 3
# Of what a run leaves beyond noise, a score has to show this share that a refit with its place may
# close half of it [1].
_REACH: Final = 0.25
# A first effect has to close this share of what is left [1]: of two that show alike and are not
# like each other either closes about half alone, of two that cover each other a little less.
_PART: Final = 0.25
_FINE: Final = (
    "What is left in smooth shapes is no more than noise and what the shapes of places may make "
    f"wrong, {100 * ELSEWHERE:g} % of an effect elsewhere. Scores beside a place come from its "
    f"edges as well; of what is all over the body none scores {CLEAR:g} thresholds or more"
)
# What the finer cells are still wrong by may pass the threshold, hardly so many times [1].
_SLIGHT: Final = 3.0
_CELLS: Final = (
    "A score of {:.3g} passed the threshold against cells {:g} times as short as a fit's, and none "
    "does against cells {:g} times as short: it came from the cells."
)
# Worth telling [1].
_FAR: Final = 1.05
_SCATTER: Final = (
    "Cells {:g} times as short as a fit's may still be wrong by so much that scores scatter {:.2g} "
    "times as far as by noise alone, and the threshold is as much higher. A larger "
    "mesh.cells_per_depth, 1 by default, leaves less and takes longer."
)
_COLLINEAR: Final = (
    "Together {} meet the readings, but each of them may as well be nothing beside the others: "
    "they make up for each other, and what is missing is none of them for certain."
)
_NO_PAIR: Final = (
    "The first effect closes less than half of the gap, and with a second one {:.0f} % of it are "
    "closed: neither is named."
)
# An effect may as well be absent where scatter gives strengths as large with this chance, and
# explains as much of what is left [1].
_ABSENT: Final = 0.05


@final
@dataclass(frozen=True)
class SearchPath:
    """How far a search went.

    - `begun`: where it began, cells and steps checked; `standing`: where it ended, no doubt about
      places allowed for.
    - `table`: the scores before anything was put to work; `calibrated`: its alarms by simulation.
    - `rivals`: of the last effect at work, those that came near it.
    """

    word: Word
    rounds: list[Round]
    begun: Standing
    standing: Standing
    table: ScoreTable
    remarks: list[str]
    calibrated: Calibration
    rivals: Sequence[Refit]


def search(begun: Standing, laws: tuple[Candidate, ...], pace: Pace, *, rough: bool) -> SearchPath:
    """Put effects to work one after the other until nothing is missing, or nothing explains it.

    `rough`: whether cells make more wrong than noise does, so that any alarm may come from them.
    """
    standing, rounds, remarks, quiet, tried = begun, [], [], False, False
    tables: list[ScoreTable] = []
    rivals: dict[Active, Sequence[Refit]] = {}
    settled = doubted = begun
    for number in range(_ROUNDS):
        share = 0.5**number
        pace.step(f"scoring all candidates, round {number + 1} of {_ROUNDS} at the most")
        table = told_by(standing, laws, share)
        if not tried and _slight(standing, table, rough):
            tried = True
            checking = standing, begun, share, laws, table, pace, remarks
            standing, table = checked(*checking, rough=rough)
            begun = begun if number else standing
        tables.append(table)
        calm = standing.chance() > share * BY_SHAPES
        if (rest := _at_rest(standing, table, calm)) is not None:
            remarks += rest
            break
        made = put_first(refits(standing, table, laws, pace), table.threshold**2)
        one = make_round(standing, made, table) if made else None
        stop = _stopped(one, rounds, calm)
        if one is None or stop is not None:
            quiet = not rounds and _absent(one, calm)
            remarks += stop or []
            break
        rounds.append(_told(one, pace))
        before, standing = standing, with_all(made[0], standing)
        rivals |= rivals_of(made, before, one.together if tentative(one) else ())
        standing, rounds = pruned(standing, rounds, table.threshold**2, pace, remarks)
        if one.closed < _PART:
            break
        if tentative(rounds[0]) and len(rounds) > 1 and _unmet(begun, standing):
            remarks.append(_NO_PAIR.format(100 * share_closed(begun, standing)))
            break
        if not tentative(rounds[-1]):
            # Before, most of the gap is still there, and what is left is not a shape's or cells'.
            most = table.threshold**2
            standing, rounds = _formed(standing, rounds, begun, before, most, pace, remarks)
        pace.step("allowing for what the shapes of places may make wrong")
        settled = standing
        standing = doubted = with_doubt(standing, begun.allowed)
        standing, rounds, told = replaced(standing, rounds, rivals, table.threshold**2, pace)
        if told:
            remarks += told
            settled = standing
            standing = doubted = with_doubt(standing, begun.allowed)
    pace.step("fitting what was found once more, and drawing noise alone")
    last, doubted = _ended(settled, standing, standing is doubted, begun, pace)
    together = with_joint_effects(rounds, last, doubted)
    word = "no_gap" if quiet else _word(begun, last, together, tables[0])
    others = rivals.get(last.active[-1], ()) if last.active else ()
    remarks += twice([name for name, _ in last.active]) + made_up(together)
    alarms = calibrated(begun, tables[0])
    return SearchPath(word, together, begun, last, tables[0], remarks, alarms, others)


def _formed(
    standing: Standing,
    rounds: list[Round],
    begun: Standing,
    before: Standing,
    most: float,
    pace: Pace,
    remarks: list[str],
) -> tuple[Standing, list[Round]]:
    """The last effect over a place of the form, and on cells, that it asks for; `most`: squares."""
    # The form of a place that is thinner than a cell shows on smaller ones alone.
    shows, told = thinnest(standing) >= edge_of(standing.bench), (standing, rounds)
    if shows:
        told = with_an_edge(standing, rounds, before, most, pace)
    smaller = on_small_cells(*told, begun, before, pace, remarks)
    same = shows and smaller[0] is told[0]
    return smaller if same else with_an_edge(*smaller, before, most, pace)


def _ended(
    settled: Standing, standing: Standing, latest: bool, begun: Standing, pace: Pace
) -> tuple[Standing, Standing]:
    """Where a search ended, no doubt about places allowed for, and with that.

    Where that doubt is the `latest`, what was `settled` just before it need not be fitted again.
    """
    last = undoubted(settled if latest else standing, begun.allowed)
    return by_fine_slopes(last, standing, pace)


def _told(one: Round, pace: Pace) -> Round:
    """The round itself, told with its best effect, not at its end yet, and what is left [K]."""
    before, after = one.rms_before, one.rms_after
    left = ", ".join(f"{run} {before[run]:.3g} to {after[run]:.3g} K" for run in before)
    best = one.effect
    unit = "" if best.card.unit == "1" else f" {best.card.unit}"
    at = f" {best.part}" if best.part else "" if best.side is None else f" at {best.side}"
    if best.side is None and best.centre is not None:
        at = f" at ({', '.join(f'{1e3 * way:.1f}' for way in best.centre)}) mm"
    others = "".join(f" or {name}" for name in one.together if name != best.card.name)
    pace.step(f"put to work: {best.card.name} {best.strength:.3g}{unit}{at}{others}; {left}")
    return one


def checked(
    standing: Standing,
    begun: Standing,
    share: float,
    laws: tuple[Candidate, ...],
    table: ScoreTable,
    pace: Pace,
    remarks: list[str],
    *,
    rough: bool,
) -> tuple[Standing, ScoreTable]:
    """What cells make wrong measured against smaller ones, and scores [1] with that.

    Near a lamp that has just been lit heat has not gone as deep as a cell is wide, and what is left
    of the error there may look like a slow lamp; at an inner edge that is lit errors fall slowly.
    Where there can be none, or a search is not on the mesh any more on which it had `begun`, all
    stays as it is. `share`: as for `told_by`.
    """
    why = ", as a fit's make much wrong" if rough else ""
    pace.step(f"checking {'an' if rough else 'a slight'} alarm on smaller cells{why}")
    bench = finest(standing.bench)
    if bench is standing.bench or bench.ready is not begun.bench.ready:
        return standing, table
    standing = refined(standing, bench, rough=rough)
    anew = told_by(standing, laws, share)
    raised = [abs(one.z) for one in table.scores if credible(one, table.threshold)]
    if standing.bench.scatter > _FAR:
        remarks.append(_SCATTER.format(FINEST, standing.bench.scatter))
    if raised and not _alarm(anew):
        remarks.append(_CELLS.format(max(raised), FINER, FINEST))
    return standing, anew


def told_by(standing: Standing, laws: tuple[Candidate, ...], share: float) -> ScoreTable:
    """The scores that tell of an effect more; beside places that leave no misfit, those far beyond.

    `share`: of the chance of a false alarm that a round has [1].
    """
    table = scored(standing, laws, alpha=share * _BY_SCORE)
    fine = placed(standing) and standing.chance() > share * BY_SHAPES
    return clear_of_shapes(table, standing.first) if fine else table


def _slight(standing: Standing, table: ScoreTable, rough: bool) -> bool:
    """Whether there is an alarm that no large score raises, of those that could be an effect.

    Where cells are `rough` any alarm may be theirs.
    """
    raised = [abs(one.z) for one in table.scores if credible(one, table.threshold)]
    alarm = bool(raised) or standing.chance() <= BY_SHAPES
    return alarm and (rough or all(one < _SLIGHT * table.threshold for one in raised))


def calibrated(begun: Standing, table: ScoreTable) -> Calibration:
    """How often the stated model's alarm would be false, by simulation [1]."""
    follows = table, projection(begun.ended.slopes), begun.allowed.runs

    def anew() -> list[np.ndarray]:
        made = calibration(*follows, shapes=BY_SHAPES)
        return [made.largest, np.array([made.by_score, made.by_shapes, made.either])]

    kept = begun.bench.memory.recalled("calibration", (*follows, BY_SHAPES), anew)
    return Calibration(kept[0], *map(float, kept[1]))


def pruned(
    standing: Standing, rounds: list[Round], most: float, pace: Pace, remarks: list[str]
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
        pace.step(f"trying without {effect.card.name}")
        less = fitted(without(standing, number), times=1)
        if less.ended.criterion(spread) - standing.ended.criterion(spread) < most:
            remarks.append(f"{effect.card.name} was tried, and is not needed beside the others.")
            return less, rounds[:number] + rounds[number + 1 :]
    return standing, rounds


def _at_rest(standing: Standing, table: ScoreTable, calm: bool) -> list[str] | None:
    """What there is to say where nothing more is looked for; None where something is."""
    if not _alarm(table) and calm:
        return [_fine(table)] if placed(standing) else []
    if standing.active and _out_of_reach(standing, table):
        return [_rest(None)]
    return None


def _fine(table: ScoreTable) -> str:
    """What to say where scores beside a place are not followed, if there are such."""
    could_be = [one for one in table.unfollowed if credible(one, 0.0)]
    largest = next(iter(best_of_kinds(could_be)), None)
    told = largest and f": the largest, {largest.name()}, {abs(largest.z) / table.threshold:.2g}"
    return f"{_FINE}{told or ''}. Nothing more was looked for."


def _absent(one: Round | None, calm: bool) -> bool:
    """Whether all that is left is an effect that may as well be nothing.

    Strengths by themselves do not tell: where readings see but a flank of a place, that may make up
    for any strength, so that its error is far larger than what it explains leaves room for.

    Source: Hauck and Donner, J. Am. Statist. Assoc. 72 (1977) 851, what Wald's test misses.
    """
    return calm and one is not None and min(one.effect.chance, one.p_value) > _ABSENT


def _stopped(one: Round | None, rounds: list[Round], calm: bool) -> list[str] | None:
    """What there is to say where a round adds nothing to those before; None where it does."""
    if one is None:
        return [_rest(one)] if rounds else []
    if _absent(one, calm):
        return [_nothing(one)]
    if one.effect.card.fault:
        return [_fault(one.effect)]
    return [_rest(one)] if rounds and one.closed < WORTH else None


def put_first(made: list[Refit], most: float) -> list[Refit]:
    """The simplest of refits that explain as much first, what cells make wrong measured with it.

    `most`: in squares, as for `together` [1].
    """
    order = simplest_first(made, most)
    if order and order[0] is not made[0]:
        first = replace(order[0], standing=fitted(order[0].standing, times=1))
        if lost(first.standing):
            return [one for one in made if one is not order[0]]
        order[0] = first
    return order


def _out_of_reach(standing: Standing, table: ScoreTable) -> bool:
    """Whether far more is left than any candidate shows in: a level of noise is not that wrong."""
    more = 0.0
    for run in standing.allowed.runs:
        part = standing.ended.residual[run.part]
        squares, count = float(part @ part), np.count_nonzero(part)
        more += squares - count if squares > run.level * count else 0.0
    most = max((one.z**2 for one in table.scores), default=0.0)
    return bool(most < _REACH * more)


def _nothing(one: Round) -> str:
    low, high = one.effect.interval95
    return (
        f"The score of {one.effect.card.name} passes the threshold, but fitted it is "
        f"{one.effect.strength:.3g} [{low:.3g}, {high:.3g}] {one.effect.card.unit}, which may be "
        "nothing, and nothing else is left."
    )


def twice(names: list[str]) -> list[str]:
    """What to say of kinds that are at work at two places."""
    return [
        f"{name} is at work at {names.count(name)} places, which may be one of another shape than "
        "is looked for."
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]


def _fault(found: Effect) -> str:
    return (
        f"What is left is met best by a fault of the record, {found.card.name} of "
        f"{found.strength:.3g} {found.card.unit}, which is not an effect on the body. What would "
        f"show it: {found.card.split_by}."
    )


def _rest(one: Round | None) -> str:
    if one is None:
        return (
            "More than noise is left (rms_after of the last round), in which no candidate shows by "
            "much: what was put to work may hold a part of it."
        )
    name = one.effect.card.name
    return (
        f"A rest is left that no candidate explains; the closest is {name}, "
        f"which closes {100 * max(one.closed, 0.0):.0f} % of it."
    )


def _word(begun: Standing, last: Standing, rounds: list[Round], table: ScoreTable) -> Word:
    if not rounds:
        gap = _alarm(table) or begun.chance() <= BY_SHAPES
        return "none_of_mine" if gap else "no_gap"
    unmet = _unmet(begun, last)
    return "none_of_mine" if unmet or collinear(rounds) else verdict_of(rounds)


def _unmet(begun: Standing, last: Standing) -> bool:
    """Whether effects close too little of the gap to be named, and leave more than noise."""
    return share_closed(begun, last) < CLOSED and last.chance() <= BY_SHAPES


def made_up(rounds: Sequence[Round]) -> list[str]:
    """What to say of effects that make up for each other."""
    names = ", ".join(one.effect.card.name for one in rounds)
    return [_COLLINEAR.format(names)] if collinear(rounds) else []


def collinear(rounds: Sequence[Round]) -> bool:
    """Whether of several effects at work each may as well be nothing beside the others.

    Source: Belsley, Kuh and Welsch, Regression Diagnostics (1980), chapter 3, collinearity.
    """
    return len(rounds) > 1 and all(one.effect.chance > _ABSENT for one in rounds)


def verdict_of(rounds: Sequence[Round]) -> Word:
    """Of rounds that explain the gap."""
    return "named" if all(len(one.together) == 1 for one in rounds) else "inseparable"


def _alarm(table: ScoreTable) -> bool:
    return any(credible(one, table.threshold) for one in table.scores)

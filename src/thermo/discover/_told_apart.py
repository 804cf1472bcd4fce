"""Effects that fitted runs do not tell apart, told apart by runs that were held out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.stats import chi2

from thermo.discover._at_rest import KNOWN, rest_residual
from thermo.discover._bench import FINEST, Bench, finest
from thermo.discover._held_out import held_out
from thermo.discover._pace import Pace
from thermo.discover._path import CLOSED, SearchPath, verdict_of
from thermo.discover._place_doubt import ELSEWHERE, undoubted, with_doubt
from thermo.discover._refits import Refit, with_all
from thermo.discover._rounds import (
    alternative_of,
    effect_of,
    rms,
    together,
    with_joint_effects,
    with_set,
)
from thermo.discover._standing import BY_SHAPES, Standing, share_closed
from thermo.discover._verdict import Alternative, HeldOut
from thermo.inverse import FINER, NORMAL, mesh_for

Proof = Mapping[str, HeldOut]
"""By run that was not fitted."""

# Of two effects that both hold, with strengths known alike, one leaves on another run so many times
# what the other leaves, or noise, with a chance of 5 % at the most: P(x > 30 / s) P(x < 1 / s) over
# all scales s of what strengths make wrong there, x a square of one degree of freedom [1].
_BEYOND: Final = 30.0

# What is left on a run that was not fitted, over its noise, where a model counts as right [1].
_MET: Final = 1.1

# Share of squares that is closed at the least, else [1]: an effect of which as much is elsewhere as
# the shape of a place may make wrong leaves the rest.
_HELD: Final = 1 - ELSEWHERE**2


# Chance of as large a difference before the runs [1].
_BY_REST: Final = 1e-3

_IMPOSSIBLE: Final = (
    "What was found in the fitted runs would lead to temperatures that there cannot be on {}: it "
    "is not what is missing, and what is left there is told of the stated model alone."
)


def told_apart(path: SearchPath, pace: Pace) -> tuple[SearchPath, Proof]:
    """What is predicted of held-out runs; and the path without what they exclude.

    Of the last effect's rivals that explain the fitted runs as well each is predicted there too.
    One that leaves far more than another, or is refuted where another is not, is taken out of the
    set, and where that is the effect at work, the one that leaves least takes its place. So does
    the first that explains enough where quiet frames speak against the one at work. Where they do
    against all, or all are refuted, on smaller cells as well, nothing is named.
    """
    path, proof = _judged(path, pace)
    off = [name for name, one in proof.items() if _impossible(one)]
    if not off:
        return path, proof
    stated = {name: replace(proof[name], rms_after=proof[name].rms_before) for name in off}
    remarks = [*path.remarks, _IMPOSSIBLE.format(", ".join(off))]
    return replace(path, word="none_of_mine", remarks=remarks), {**proof, **stated}


def _judged(path: SearchPath, pace: Pace) -> tuple[SearchPath, Proof]:
    """As `told_apart`, infinitely much left where there can be no such temperatures."""
    path, proof = _without_excluded(path, pace)
    if path.word not in ("named", "inseparable"):
        return path, proof
    wrong = wrong_at_rest(path.begun, path.standing)
    if wrong:
        path = _right_at_rest(path, wrong, pace)
        if path.word == "none_of_mine":
            return path, proof
        proof = held_out(path.standing.bench, path.begun.point, path.standing.point)
    if not any(map(refuted, proof.values())) or any(map(_impossible, proof.values())):
        return path, proof
    remarks, large = list(path.remarks), proof
    benches = half_and_third(path.standing.bench, path.begun.bench)
    if benches is not None:
        pace.step("predicting held-out runs on cells of two sizes")
        points = path.begun.point, path.standing.point
        large, proof = (held_out(bench, *points) for bench in benches)
        if any(map(_impossible, proof.values())):
            return path, proof
    against = [name for name, one in proof.items() if refuted(less_cells(large[name], one))]
    remarks += [_cells(name, large[name], one) for name, one in proof.items()
                if refuted(large[name]) and name not in against]  # fmt: skip
    if not against:
        return replace(path, remarks=remarks), proof
    remarks += [_refuted(name, proof[name]) for name in against]
    return replace(path, word="none_of_mine", remarks=remarks), proof


def _impossible(one: HeldOut) -> bool:
    """Whether there can be no such temperatures as are predicted of a run."""
    return not np.isfinite(one.rms_after)


def wrong_at_rest(begun: Standing, standing: Standing) -> str:
    """What to say where quiet frames speak against effects on the readings; else nothing.

    Against them and not against what is stated: cameras may be off otherwise before each run.
    """
    cases = standing.bench.coarse.cases
    before, after = (
        np.asarray(rest_residual(cases, one.point.candidates)) for one in (begun, standing)
    )
    told = float(after @ after)
    known = sum(int(np.isfinite(np.asarray(case.resting)).sum()) for case in cases)
    if told <= before @ before or chi2.sf(told, known - 1) > _BY_REST:
        return ""
    numbers = standing.bench.coarse.sequence
    high, low = (
        standing.bench.task.runs[numbers[int(at)]].name for at in (after.argmax(), after.argmin())
    )
    return (
        f"With what explains the fitted runs quiet frames of {high} would be "
        f"{KNOWN * np.ptp(after):.2g} K higher than they are, beside those of {low}, and that is "
        f"known to {KNOWN:g} K. It is not what is missing."
    )


def _right_at_rest(path: SearchPath, wrong: str, pace: Pace) -> SearchPath:
    """The path with a rival of its last effect that quiet frames do not speak against.

    That has to leave as little as what is named does, but not as little as the effect that was at
    work: what the shape of a place makes wrong, an effect that is refuted may take up. Where there
    is none nothing is named.
    """
    name = path.standing.active[-1][0]
    kept: dict[str, tuple[Refit, Standing]] = {}
    for one in filter(_explains, _rivals(path)):
        pace.step(f"trying {one.name()} in place of {name}, which quiet frames speak against")
        there = _in_place(path, one)
        if not wrong_at_rest(path.begun, there):
            kept[one.name()] = one, there
    if not kept:
        return replace(path, word="none_of_mine", remarks=[*path.remarks, wrong])
    best, _ = next(iter(kept.values()))
    most = path.rounds[-1].threshold ** 2
    names = together([one for one, _ in kept.values()], best.standing.misfit(), most)
    remarks = [*path.remarks, f"{wrong} {best.name()} takes the place of {name}."]
    fits = {each: there for each, (_, there) in kept.items()}
    after = _with(replace(path, remarks=remarks), best.name(), names, fits)
    *before, last = after.rounds
    last = replace(last, closed=share_closed(best.begun, best.standing))
    return replace(after, rounds=[*before, last])


def _explains(one: Refit) -> bool:
    """Whether an effect closes as much of a gap as what is named has to, or leaves noise."""
    closed = share_closed(one.begun, one.standing)
    return closed >= CLOSED or one.standing.chance() > BY_SHAPES


def _in_place(path: SearchPath, rival: Refit) -> Standing:
    """The standing with a rival of the last effect at work, no doubt about places allowed for."""
    return undoubted(with_all(rival, path.standing), path.begun.allowed)


def _rivals(path: SearchPath) -> list[Refit]:
    """Of the last effect, those beside the same others that are not at work."""
    *others, last = path.standing.active
    return [
        one
        for one in path.rivals
        if list(one.standing.active[:-1]) == others and one.name() != last[0]
    ]


def half_and_third(bench: Bench, begun: Bench) -> tuple[Bench, Bench] | None:
    """Benches that predict on cells half and a third as long as a fit's; None where none do.

    Where a search did not stay on the mesh on which it had `begun`, cells are small already.
    """
    if bench.ready is not begun.ready or (third := finest(bench)) is bench:
        return None
    half = mesh_for(bench.task, bench.ready.stated, FINER)
    return replace(bench, finer=half), third


def less_cells(large: HeldOut, small: HeldOut) -> HeldOut:
    """What is left on small cells [K], without what they may still be wrong by.

    As much as they took off may be left: at an inner edge, where errors fall with the cells' edges
    to the power of 4/3 or less, cells of a third leave half of what those of a half did, or more.

    Source: Strang and Fix, An Analysis of the Finite Element Method (1973), chapter 8.
    """
    fell = max(large.rms_after**2 - small.rms_after**2, 0.0)
    return replace(small, rms_after=float(np.sqrt(max(small.rms_after**2 - fell, 0.0))))


def refuted(one: HeldOut) -> bool:
    """Whether a run that was not fitted speaks against what explains those that were.

    More is left than noise, at the upper end of its 95 % interval, and surely more than a place
    whose shape is a guess would leave. With too few samples to be sure, or nothing to close, the
    difference has to grow.
    """
    if one.rms_after <= _MET * one.noise * np.sqrt(1 + NORMAL * one.doubt):
        return False
    if one.interval95 is None:
        return one.rms_after > one.rms_before
    return one.interval95[1] < _HELD


def _without_excluded(path: SearchPath, pace: Pace) -> tuple[SearchPath, Proof]:
    """The path without those of the last effect's rivals that held-out runs exclude."""
    pace.step("predicting held-out runs")
    begun = path.begun.point
    proof = held_out(path.standing.bench, begun, path.standing.point)
    if path.word != "inseparable" or not proof:
        return path, proof
    name, alike = path.rounds[-1].effect.card.name, path.rounds[-1].together
    there = {name: (path.standing, proof)}
    for one in _rivals(path):
        if one.name() in alike:
            pace.step(f"predicting held-out runs with {one.name()} in place of {name}")
            standing = _in_place(path, one)
            there[one.name()] = standing, held_out(standing.bench, begun, standing.point)
    proofs = {each: found for each, (_, found) in there.items()}
    out = excluded(proofs)
    if not out:
        return _proved(path, proofs), proof
    kept = [each for each in alike if each not in out]
    best = min((each for each in kept if each in there), key=lambda each: excess(proofs[each]))
    remarks = [*path.remarks, _excluded(best, there[best][1], out)]
    fits = {each: standing for each, (standing, _) in there.items()}
    after = _with(replace(path, remarks=remarks), best, kept, fits)
    return _proved(after, proofs), there[best][1]


def _proved(path: SearchPath, proofs: Mapping[str, Proof]) -> SearchPath:
    """The path, and of its last effect's alternatives what they leave on held-out runs [K]."""
    *before, last = path.rounds
    told = {
        name: replace(one, held_out={run: each.rms_after for run, each in proofs[name].items()})
        if name in proofs
        else one
        for name, one in last.alternatives.items()
    }
    return replace(path, rounds=[*before, replace(last, alternatives=told)])


def excess(proof: Proof) -> float:
    """Mean over runs of the square that is left over that of noise, less one [1]."""
    return float(np.mean([(one.rms_after / one.noise) ** 2 for one in proof.values()]) - 1)


def excluded(proofs: Mapping[str, Proof]) -> dict[str, Proof]:
    """By effect, what those leave that leave far more than the best, or are refuted; never all."""
    least = max(min(map(excess, proofs.values())), 1.0)
    far = {name for name, one in proofs.items() if excess(one) > _BEYOND * least}
    against = {name for name, one in proofs.items() if any(map(refuted, one.values()))}
    out = far | against if len(far | against) < len(proofs) else far
    return {name: one for name, one in proofs.items() if name in out}


def _with(path: SearchPath, best: str, kept: list[str], fits: Mapping[str, Standing]) -> SearchPath:
    """The path with the best of those that are kept at work in its last round.

    `fits`: by effect, where the fit with it stands.
    """
    *before, last = path.rounds
    standing, others = fits[best], [one for one in kept if one != best]
    more = [_alternative(fits[one]) for one in others if one in fits]
    if best == last.effect.card.name:
        rounds = [*before, with_set(last, [best, *others], *more)]
    else:
        effect = effect_of(standing, standing.active[-1], standing.misfit())
        fresh = replace(last, effect=effect, rms_after=rms(standing))
        fresh = with_set(fresh, [best, *others], *more)
        doubted = with_doubt(standing, path.begun.allowed)
        rounds = with_joint_effects([*before, fresh], standing, doubted)
    return replace(path, word=verdict_of(rounds), rounds=rounds, standing=standing)


def _alternative(standing: Standing) -> Alternative:
    return alternative_of(standing, standing.active[-1], standing.misfit())


def _cells(run: str, large: HeldOut, small: HeldOut) -> str:
    """What to say of a run on which cells may be all that is left."""
    return (
        f"On {run} cells {FINER:g} times as short as a fit's leave {large.rms_after:.3g} K, and "
        f"cells {FINEST:g} times as short {small.rms_after:.3g} K: the rest may come from them."
    )


def _refuted(run: str, one: HeldOut) -> str:
    """What to say of a run that speaks against what was found."""
    share = ""
    if one.gap_closed is not None:
        closed = f"{100 * max(one.gap_closed, 0):.3g} % closed"
        share = f", {closed}, less than the {100 * _HELD:g} % that one in the right place closes"
    return (
        f"What explains the fitted runs does not hold on {run}: {one.rms_before:.3g} K become "
        f"{one.rms_after:.3g} K there, at a noise of {one.noise:.3g} K{share}. It is not what is "
        "missing, unless it was at work in the fitted runs only."
    )


def _excluded(best: str, proof: Proof, out: Mapping[str, Proof]) -> str:
    """What to say of those that are taken out."""
    told = "; ".join(
        f"{name} leaves {_left(one)} on {run}, {best} {proof[run].rms_after:.3g} K"
        for name, found in out.items()
        for run, one in found.items()
    )
    return (
        f"Held-out runs tell apart what explains the fitted ones alike: {told}. They have been "
        "used for that, and are no proof by themselves any more."
    )


def _left(one: HeldOut) -> str:
    return "temperatures that there cannot be" if _impossible(one) else f"{one.rms_after:.3g} K"

"""A round of the search in numbers: what was scored, what was refitted, what is best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jax.flatten_util import ravel_pytree
from scipy.stats import chi2

from thermo.discover._candidate import Candidate, Inclusion, Transition
from thermo.discover._conductance import conductance_of, strength_between
from thermo.discover._descent import Ended
from thermo.discover._entries import Active, Entry, entry_of
from thermo.discover._met import met_runs
from thermo.discover._parameters import parameter_intervals, values
from thermo.discover._refits import Refit
from thermo.discover._scores import ScoreTable, best_of_kinds
from thermo.discover._standing import Standing, free_of, share_closed
from thermo.discover._verdict import Alternative, Candidacy, Effect, Round
from thermo.discover._within_body import within_body
from thermo.inverse import NORMAL
from thermo.mesh import face_areas


def make_round(before: Standing, made: list[Refit], table: ScoreTable) -> Round:
    """What the best of the refits explains, and which others explain as much [1].

    One stays beside the best unless that gains more over it than the threshold squared, by the
    criterion or by what is left alone: freedom that a rival had no need of is no ground to exclude
    it. Where the best leaves more than noise, what it leaves counts as noise: the misfit of a
    model that is not quite right tells rivals apart less well than the noise alone would. Noise
    has as many chances to explain as much as parts were scored.

    Source: McCullagh and Nelder, Generalized Linear Models (1989), section 9.2, quasi-likelihood;
    Wilks, Ann. Math. Statist. 9 (1938) 60, the ratio of likelihoods; Bonferroni's inequality.
    """
    best = made[0]
    spread = best.standing.misfit()
    ended = {one.name(): one.standing.ended for one in made}
    least = min(one.loss() for one in ended.values())
    left = {name: one.loss() - least for name, one in ended.items()}
    whole = max(before.ended.loss() - least, 1e-12)
    gain = 2 * (before.ended.loss() - ended[best.name()].loss()) / spread
    more = ended[best.name()].fitted() - before.ended.fitted()
    as_good = together(made, spread, table.threshold**2)
    return Round(
        candidates=candidacies(table, left, whole, evidence(before.ended, ended)),
        threshold=table.threshold,
        effect=effect_of(best.standing, best.standing.active[-1], spread),
        together=as_good,
        p_value=min(1.0, len(table.scores) * float(chi2.sf(gain, more))),
        rms_before=rms(before),
        rms_after=rms(best.standing),
        closed=share_closed(before, best.standing),
        alternatives={
            one.name(): alternative_of(one.standing, one.standing.active[-1], spread)
            for one in made[1:]
            if one.name() in as_good
        },
    )


def alternative_of(standing: Standing, active: Active, spread: float) -> Alternative:
    """An effect where a fit with it in place of another ended, and the fields there [SI].

    `spread`: what is left over noise, by which errors are widened, as for `effect_of` [1].
    """
    told, intervals = values(standing, standing.point), parameter_intervals(standing)
    parameters = {name: (value, intervals[name]) for name, value in told.items()}
    return Alternative(effect_of(standing, active, spread), parameters, rms(standing))


def with_set(one: Round, names: Sequence[str], *more: Alternative) -> Round:
    """A round with these in its set, the best first, and of its alternatives those among them.

    `more`: alternatives that are new, or fitted anew.
    """
    fits = {**one.alternatives, **{each.effect.card.name: each for each in more}}
    kept = {name: fits[name] for name in names[1:] if name in fits}
    return replace(one, together=list(names), alternatives=kept)


def together(made: list[Refit], spread: float, most: float) -> list[str]:
    """Names of refits that the first does not exclude, by `most` in squares over `spread` [1]."""
    first = made[0].standing.ended
    return [one.name() for one in made if min(behind(one.standing.ended, first, spread)) < most]


def behind(one: Ended, first: Ended, spread: float) -> tuple[float, float]:
    """By how much a fit is behind the first, by Akaike's criterion and by what it leaves alone.

    Both in squares over the variance `spread` of what counts as noise [1].
    """
    return (
        one.criterion(spread) - first.criterion(spread),
        2 * (one.loss() - first.loss()) / spread,
    )


def simplest_first(made: list[Refit], most: float) -> list[Refit]:
    """Refits in their order, but the simplest of those that explain as much before all others.

    An effect is simpler than a fault of the record, and of two the one with fewer entries that were
    fitted. `most`: in squares, as for `together` [1].
    """
    if not made:
        return made
    as_good = together(made, made[0].standing.misfit(), most)
    first = min(
        (one for one in made if one.name() in as_good),
        key=lambda one: (one.score.entry.card.fault, one.standing.ended.fitted()),
    )
    return [first, *(one for one in made if one is not first)]


def evidence(before: Ended, refitted: Mapping[str, Ended]) -> dict[str, float]:
    """Schwarz's criterion of each refit less that without it, below zero where it is better [1].

    Source: Burnham and Anderson, Model Selection (2002), section 6.4, BIC.
    """
    price = float(np.log(np.count_nonzero(before.residual)))
    return {
        name: 2 * (one.loss() - before.loss()) + price * (one.fitted() - before.fitted())
        for name, one in refitted.items()
    }


def candidacies(
    table: ScoreTable, left: dict[str, float], whole: float, bic: Mapping[str, float]
) -> list[Candidacy]:
    """The best part of each kind, by its score; `left` of `whole` by the kinds refitted [1]."""
    alike: dict[str, float] = {}
    for one in table.scores:
        alike[one.name()] = max(alike.get(one.name(), 0.0), one.correlation)
    return [
        Candidacy(
            one.entry.card,
            one.z,
            float(one.strength[-1]),
            one.sd,
            one.visible,
            left[one.name()] / whole if one.name() in left else None,
            alike[one.name()],
            bic.get(one.name()),
        )
        for one in best_of_kinds(table.scores)
    ]


def rms(standing: Standing) -> dict[str, float]:
    """Root mean square of simulation less readings, by run [K]."""
    return {name: one.rmse for name, one in met_runs(standing).items()}


def effect_of(
    standing: Standing, active: Active, spread: float, doubted: Standing | None = None
) -> Effect:
    """An effect at work where a fit ended, its errors widened by the misfit that is left [1].

    `doubted`: the fit with more allowed for, whose errors are taken in place of its own.
    """
    point = standing.point
    entry = entry_of(point, active)
    free = free_of(standing)
    slopes = (doubted or standing).ended.slopes
    covariance = np.linalg.pinv(slopes.T @ slopes, hermitian=True) * spread
    own = [int(np.flatnonzero(free.number == one)[0]) for one in entry.strengths]
    sd = float(np.sqrt(covariance[own[-1], own[-1]]) * free.scale[own[-1]])
    candidate = point.candidates[entry.kind]
    strengths = np.asarray(ravel_pytree(point)[0])[entry.strengths] / free.scale[own]
    inverse = np.linalg.pinv(covariance[np.ix_(own, own)], hermitian=True)
    chance = float(chi2.sf(strengths @ inverse @ strengths, len(own)))
    joint = tuple(map(float, candidate.strength)) if entry.card.joint else ()
    value = joint[-1] if joint else float(candidate.strength[entry.part])
    centre, size = _place(standing, entry)
    band = candidate.place if isinstance(candidate.place, Transition) else None
    at = None if band is None else (float(band.centre[entry.part]), float(band.size[entry.part]))
    whole = conductance_of(standing, active, free, covariance)
    low, high = entry.card.low, entry.card.high
    taken = None if whole is None else _within(*whole, 0.0 if low >= 0 else -np.inf, np.inf)
    between = taken and strength_between(standing, active, free, covariance, taken)
    return Effect(
        entry.card, value, sd, between or _within(value, sd, low, high), centre, size, at,
        None if whole is None else whole[0], taken, joint, _side(entry), _depth(candidate, entry),
        _outline(candidate, entry), dict(enumerate(entry.card.parts)).get(entry.part),
        chance=chance,
    )  # fmt: skip


def _within(value: float, sd: float, low: float, high: float) -> tuple[float, float]:
    """In which a value is in 95 % of cases, between what there can be."""
    ends = np.clip([value - NORMAL * sd, value + NORMAL * sd], low, high)
    return float(ends[0]), float(ends[1])


def with_joint_effects(rounds: list[Round], last: Standing, doubted: Standing) -> list[Round]:
    """Rounds with strengths and places of the fit in which all effects are at work [SI].

    What an effect was fitted to alone holds a part of those that came later. The errors are those
    of the fit that is `doubted`, in which the shapes of places may be others. Each round begins
    with what the one before has left [K], and the last ends with what that fit leaves: a fit that
    is doubted leaves more, as what is allowed for costs it nothing.
    """
    spread = doubted.misfit()
    after = [*(one.rms_after for one in rounds[:-1]), *([rms(last)] if rounds else [])]
    before = [*(one.rms_before for one in rounds[:1]), *after[:-1]]
    return [
        replace(
            one, effect=effect_of(last, active, spread, doubted), rms_before=begun, rms_after=ended
        )
        for one, active, begun, ended in zip(rounds, last.active, before, after, strict=True)
    ]


def _side(entry: Entry) -> str | None:
    """At which side of the body an effect is, where it is at one."""
    if entry.card.name not in ("support_contact", "backing_conduction"):
        return None
    return f"{'-+'[entry.part >= 3]}{'xyz'[entry.part % 3]}"


def _depth(candidate: Candidate, entry: Entry) -> float | None:
    """How far from the skin, or from the end of a side, an effect reaches [m]."""
    place = candidate.place
    if place is None or place.centre is not None:
        return None
    return float(place.size[entry.part])


def _outline(candidate: Candidate, entry: Entry) -> Inclusion | None:
    """The part's own place [m], where it ends at an edge."""
    place = candidate.place
    return place.only(entry.part) if isinstance(place, Inclusion) else None


def _place(standing: Standing, entry: Entry) -> tuple[np.ndarray | None, float | None]:
    """Where an effect is [m], and how far it reaches [m]."""
    place = standing.point.candidates[entry.kind].place
    if isinstance(place, Transition):
        return None, None
    if place is not None and place.centre is not None:
        middle = within_body(np.asarray(place.centre[entry.part]), standing.bench.ready.mesh)
        return middle, float(np.max(place.size[entry.part]))
    if _side(entry) is None:
        return None, None
    mesh = standing.bench.ready.mesh
    centres = mesh.nodes[mesh.faces[:, :3]].mean(1)
    axis, upper = entry.part % 3, entry.part >= 3
    end = mesh.nodes[:, axis].max() if upper else mesh.nodes[:, axis].min()
    apart = np.abs(centres[:, axis] - end)
    # Of a side that is not flat at least the outermost face.
    least = 1e-3 * np.ptp(mesh.nodes[:, axis]) + apart.min()
    there = apart <= max(least, 0.0 if place is None else float(place.size[entry.part]))
    areas = face_areas(mesh)[there]
    return (areas[:, None] * centres[there]).sum(0) / areas.sum(), float(np.sqrt(areas.sum()))

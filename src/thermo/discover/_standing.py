"""Where a search stands, and least squares from there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Bool, Float, Int
from scipy.stats import chi2

from thermo._compiled import make_room
from thermo.discover._allowance import Allowance
from thermo.discover._bench import FINEST_LEFT, Bench, corrected, finer_runs, steps_for
from thermo.discover._candidate import Candidate
from thermo.discover._descent import Ended, Free, begun, descend
from thermo.discover._entries import Active, entry_of, field_entries, free_entries, joined
from thermo.discover._extended import Extended, moved
from thermo.discover._projection import projection
from thermo.discover._slope_limits import slope_limits
from thermo.discover._softening import error_columns, omnibus
from thermo.discover.candidates import (
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
)
from thermo.errors import InputError
from thermo.inverse import Objective

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
    - `held`: axes along which a patch with an edge neither moves nor grows, by its part, where any.
    """

    bench: Bench
    first: Mapping[str, Candidate]
    point: Extended
    active: tuple[Active, ...]
    ended: Ended
    allowed: Allowance
    held: Mapping[Active, Bool[np.ndarray, "3"]] = field(default_factory=dict)

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
    first = standing.bench.first(()).fields
    return joined(
        field_entries(point, first), *(_of_part(standing, one) for one in standing.active)
    )


def _of_part(standing: Standing, active: Active) -> Free:
    """The entries of a part at work, free [1]; a law stays above zero at all that was read."""
    entry, before = entry_of(standing.point, active), standing.first[active[0]]
    held = standing.held.get(active, np.zeros(3, bool))
    free = free_entries(standing.point, entry, before, box_of(standing), held)
    if not isinstance(before, TemperatureDependentConductivity | TemperatureDependentHeatCapacity):
        return free
    stated = standing.bench.ready.stated
    conducts = isinstance(before, TemperatureDependentConductivity)
    law = stated.conductivity_law if conducts else stated.capacity_law
    least, most = slope_limits(law, standing.bench.task.runs)
    return replace(free, low=np.maximum(free.low, least), high=np.minimum(free.high, most))


def box_of(standing: Standing) -> Float[np.ndarray, "2 3"]:
    """The least and the largest coordinates of the body [m]."""
    nodes = standing.bench.ready.mesh.nodes
    return np.stack([nodes.min(0), nodes.max(0)])


def share_closed(before: Standing, after: Standing) -> float:
    """Share of what is beyond noise in the smooth shapes that is gone after, 1 at the most [1].

    A gap within the scatter of noise is no measure: that scatter is then.
    """
    (told, count), (rest, _) = before.gap(), after.gap()
    return min(1.0, float((told - rest) / max(told - count, np.sqrt(2 * count))))


def without(standing: Standing, number: int) -> Standing:
    """The standing with one of its effects taken out, not fitted anew [1]."""
    name, part = standing.active[number]
    entry = entry_of(standing.point, (name, part))
    flat = np.asarray(ravel_pytree(standing.point)[0])
    change = np.zeros(len(flat))
    change[entry.strengths] = -flat[entry.strengths]
    active = tuple(one for one in standing.active if one != (name, part))
    return replace(standing, point=moved(standing.point, change), active=active)


def with_few_places(standing: Standing) -> tuple[Standing, dict[str, Parts]]:
    """The standing with few parts of effects with a place, and which they are [1]."""
    kept: dict[str, Parts] = {}
    for one in standing.point.candidates:
        name = one.card.name
        busy = sorted(part for other, part in standing.active if other == name)
        kept[name] = np.array(busy or [0]) if has_places(one) else np.arange(len(one.strength))
    candidates = tuple(take(one, kept[one.card.name]) for one in standing.point.candidates)
    first = {
        name: take(one, kept[name]) if name in kept else one for name, one in standing.first.items()
    }
    renamed = {
        (name, part): (
            name,
            int(np.searchsorted(kept[name], part)) if has_places(standing.first[name]) else part,
        )
        for name, part in standing.active
    }
    held = {renamed[one]: axes for one, axes in standing.held.items() if one in renamed}
    point, active = replace(standing.point, candidates=candidates), tuple(renamed.values())
    return replace(standing, point=point, first=first, active=active, held=held), kept


def at_work(standing: Standing) -> tuple[Candidate, ...]:
    """The effects at work, of those with places no more parts than that [SI]."""
    small, _ = with_few_places(standing)
    names = {name for name, _ in standing.active}
    return tuple(one for one in small.point.candidates if one.card.name in names)


def has_places(one: Candidate) -> bool:
    """Whether a candidate's parts are places in the body, or on the scale of temperature."""
    return one.place is not None and one.place.centre is not None


def take(one: Candidate, parts: Parts) -> Candidate:
    """A candidate with some of its places alone; one without places stays as it is [SI]."""
    if not has_places(one):
        return one
    place = jax.tree.map(lambda leaf: leaf[parts], one.place)
    return replace(one, strength=one.strength[parts], place=place)


def _put_back(one: Candidate, few: Candidate, parts: Parts) -> Candidate:
    if not has_places(one):
        return few
    place = jax.tree.map(lambda all_, some: all_.at[parts].set(some), one.place, few.place)
    return replace(one, strength=one.strength.at[parts].set(few.strength), place=place)


def fitted(standing: Standing, *, times: int, rival: float = np.inf) -> Standing:
    """Least squares from where it stands; what cells make wrong is measured `times` before [1].

    One that will not reach the loss of a `rival` [1] is not followed to its end, nor one that is
    `lost`.

    Of effects with a place only those at work take part, and one of each other kind: all refits
    share one program, and it is as small as that allows.
    """
    make_room()
    small, kept = with_few_places(standing)
    free = free_of(small)
    for number in range(max(times, 1)):
        if number < times:
            small = measured(small)
        if lost(small):
            break
        small = descended(small, free, rival)
    return with_all_places(standing, small, kept)


def with_all_places(standing: Standing, small: Standing, kept: Mapping[str, Parts]) -> Standing:
    """The standing where a fit with few places of its effects has ended [1].

    `kept`: which parts these are, as of `with_few_places`.
    """
    back = tuple(
        _put_back(one, few, kept[one.card.name])
        for one, few in zip(standing.point.candidates, small.point.candidates, strict=True)
    )
    point = replace(small.point, candidates=back)
    return replace(standing, bench=small.bench, point=point, ended=small.ended)


def measured(standing: Standing) -> Standing:
    """With what cells make wrong measured where it stands [K], not fitted anew.

    It is `lost` where temperatures on the finer cells are such as there cannot be: a law that is
    negative at some of them may burst there and not on coarse ones.
    """
    try:
        wanted = finer_runs(standing.bench, standing.point)
    except InputError:
        nothing_holds = np.full_like(standing.ended.residual, np.inf)
        return replace(standing, ended=replace(standing.ended, residual=nothing_holds))
    return replace(standing, bench=corrected(standing.bench, standing.point, wanted))


def lost(standing: Standing) -> bool:
    """Whether infinitely much is left where it stands [1]: nothing is to be fitted from there."""
    return not bool(np.isfinite(standing.ended.residual).all())


def refined(standing: Standing, bench: Bench, *, rough: bool) -> Standing:
    """Fitted anew against the smaller cells of a bench [1].

    Where cells are `rough` those too may raise a score. What they are still wrong by is as large as
    how far they are from the former ones tells; its shape is not known. Spread at random over as
    many shapes as there are smooth ones, D, an error of the norm e scatters scores by e / D^1/2
    beside noise.

    Source: Richardson, Phil. Trans. R. Soc. A 210 (1911) 307, the deferred approach to the limit;
    Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """
    here = with_few_places(standing)[0].point
    wanted = finer_runs(bench, here)
    bench = corrected(bench, here, wanted)
    after = fitted(replace(standing, bench=bench), times=0)
    if not rough:
        return after
    before = finer_runs(standing.bench, here)
    apart = [jnp.nan_to_num(one - other) for one, other in zip(wanted, before, strict=True)]
    columns = error_columns(
        after.allowed.runs, bench.coarse, apart, len(after.ended.residual), FINEST_LEFT
    )
    left = projection(after.ended.slopes).left(after.allowed.whiten(columns))
    scatter = float(np.sqrt(1 + np.sum(left**2) / after.gap()[1]))
    return replace(after, bench=replace(bench, scatter=scatter))


def descended(standing: Standing, free: Free, rival: float = np.inf) -> Standing:
    """Where least squares end [1], or ended before the search was interrupted."""
    follows = _asked(standing, free)
    return _recalled("fit", standing, (*follows, rival), lambda: descend(*follows, rival))


def not_moved(standing: Standing, free: Free) -> Standing:
    """What is left where it stands, and its slopes [1], nothing fitted; nothing holds if `lost`."""
    if lost(standing):
        return standing
    follows = _asked(standing, free)
    return _recalled("left", standing, follows, lambda: begun(*follows))


def _asked(standing: Standing, free: Free) -> tuple[Objective, Extended, Free, Allowance]:
    coarse = steps_for(standing.bench.coarse, standing.point)
    return coarse, standing.point, free, standing.allowed


def _recalled(
    kind: str, standing: Standing, follows: object, make: Callable[[], Ended]
) -> Standing:
    def anew() -> list[np.ndarray]:
        ended = make()
        return [np.asarray(ravel_pytree(ended.point)[0]), ended.residual, ended.slopes]

    at, residual, slopes = standing.bench.memory.recalled(kind, follows, anew)
    _, unravel = ravel_pytree(standing.point)
    ended = Ended(unravel(jnp.asarray(at)), residual, slopes)
    return replace(standing, point=ended.point, ended=ended)

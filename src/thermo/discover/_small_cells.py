"""Cells made smaller about a place that is at work."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.discover._bench import edge_of, resolved
from thermo.discover._candidate import Candidate, Inclusion, Place
from thermo.discover._pace import Pace
from thermo.discover._rounds import rms
from thermo.discover._softening import error_columns, omnibus
from thermo.discover._standing import BY_SHAPES, Standing, fitted, share_closed
from thermo.discover._verdict import Round
from thermo.discover.candidates import SupportContact
from thermo.errors import InputError

# Share of a gap that one that is closed may leave [1].
_LEAST: Final = 0.1
_BURST: Final = (
    "With {} at work smaller cells leave more than without it; cells stay as they are, and what "
    "they make wrong beside it is not known."
)


def on_small_cells(
    standing: Standing,
    rounds: list[Round],
    begun: Standing,
    before: Standing,
    pace: Pace,
    remarks: list[str],
) -> tuple[Standing, list[Round]]:
    """Fitted anew on smaller cells, where a place is thin or leaves a misfit that may be theirs.

    What cells make wrong about a thin place is no other effect [1]. Cells are made smaller once;
    `before`: where the search stood without the last effect.
    """
    if standing.bench.ready is not begun.bench.ready or not placed(standing):
        return standing, rounds
    thin = thinnest(standing) < edge_of(standing.bench)
    if not thin and (standing.chance() > BY_SHAPES or not may_be_cells(standing, begun)):
        return standing, rounds
    pace.step("fitting on smaller cells")
    name, large = rounds[-1].effect.card.name, rms(standing)
    try:
        bench = resolved(standing.bench, edges(standing))
    except InputError as fault:
        # What was found need not be lost for that.
        why = f"{fault.what}, {fault.value}; {fault.remedy}"
        remarks.append(f"Cells beside {name} stay as they are: {why}.")
        return standing, rounds
    smaller = fitted(replace(standing, bench=bench), times=2)
    if not smaller.ended.loss() < before.ended.loss():
        remarks.append(_BURST.format(name))
        return standing, rounds
    small, closed = rms(smaller), share_closed(before, smaller)
    ends = {run: (f"{one:.3g}", f"{small[run]:.3g}") for run, one in large.items()}
    told = ", ".join(f"{run} {one} to {two} K" for run, (one, two) in ends.items() if one != two)
    if told:
        remarks.append(f"Smaller cells change what is left beside {name}: {told}.")
    return smaller, [*rounds[:-1], replace(rounds[-1], rms_after=small, closed=closed)]


def may_be_cells(standing: Standing, begun: Standing) -> bool:
    """Whether what cells make wrong about places may be a part of what is left that counts.

    That is not known better than by how much more or less they make wrong since the search has
    `begun`, with no place at work. Where all of it is less than what a gap that is closed may leave
    of this one, what is left is another effect's, and comes first.

    Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """
    pairs = zip(standing.bench.coarse.cases, begun.bench.coarse.cases, strict=True)
    apart = [one.defect - other.defect for one, other in pairs]
    allowed, count = standing.allowed, len(standing.ended.residual)
    columns = error_columns(allowed.runs, standing.bench.coarse, apart, count, share=1.0)
    theirs, _, _ = omnibus(allowed.runs, allowed.whiten(columns).sum(axis=1))
    told, shapes = standing.gap()
    return theirs > _LEAST * (told - shapes)


def placed(standing: Standing) -> bool:
    """Whether an effect with a place [m] is at work."""
    return any(True for _ in _sizes(standing))


def thinnest(standing: Standing) -> float:
    """The least size of a place at work that cells have to resolve [m]; infinite without one.

    A footprint cuts faces wherever it ends: however small its depth is, it asks for no cells.
    """
    sizes = (size for one, size in _sizes(standing) if not isinstance(one, SupportContact))
    return min(sizes, default=np.inf)


def _sizes(standing: Standing) -> Iterator[tuple[Candidate, float]]:
    """Of each place at work in the body its candidate and its least size [m]."""
    for name, part in standing.active:
        one = next(one for one in standing.point.candidates if one.card.name == name)
        if isinstance(one.place, Place | Inclusion):
            yield one, float(np.min(np.asarray(one.place.size)[part]))


def edges(standing: Standing) -> Float[np.ndarray, "points 3"]:
    """Points [m] on the edges of inclusions at work."""
    found = [np.zeros((0, 3))]
    for name, part in standing.active:
        place = next(one.place for one in standing.point.candidates if one.card.name == name)
        if isinstance(place, Inclusion):
            found.append(place.edge(part))
    return np.concatenate(found)

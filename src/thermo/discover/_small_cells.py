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
from thermo.discover._skin import lit_skin
from thermo.discover._standing import BY_SHAPES, Standing, fitted, share_closed
from thermo.discover._verdict import Round
from thermo.discover.candidates import InDepthAbsorption, SupportContact
from thermo.errors import InputError

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
    """Fitted anew on smaller cells, where a place is thin or leaves a misfit in smooth shapes.

    What cells make wrong about a thin place is no other effect [1]. Cells are made smaller once;
    `before`: where the search stood without the last effect.
    """
    tried = standing.bench.ready is not begun.bench.ready
    needed = standing.chance() <= BY_SHAPES or thinnest(standing) < edge_of(standing.bench)
    if tried or not placed(standing) or not needed:
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
    """Points [m] on the edges of inclusions at work, and where light that goes deeper enters."""
    found = [np.zeros((0, 3))]
    for name, part in standing.active:
        one = next(one for one in standing.point.candidates if one.card.name == name)
        if isinstance(one.place, Inclusion):
            found.append(one.place.edge(part))
        if isinstance(one, InDepthAbsorption):
            found.append(lit_skin(standing.bench.task.runs, standing.bench.finer))
    return np.concatenate(found)

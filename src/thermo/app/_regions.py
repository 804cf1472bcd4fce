"""Regions of the surface whose means are asked for, and what is found of them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np
from jaxtyping import Bool

from thermo.app._configuration import number
from thermo.app._fitted import Fitted
from thermo.app._time_limit import OutOfTime, TimeLimit
from thermo.errors import InputError
from thermo.identify import SURFACE, RegionMean, region_mean, region_profile
from thermo.inverse import FieldPosterior, load_estimate
from thermo.mesh import faces_where

LEAST: Final = 14
"""Simulations [1] that a profile takes where the sum of squares is a parabola: `region_profile` on
a linear case."""

Regions = Mapping[str, Bool[np.ndarray, " faces"]]
"""By name, whether a face of the fit's mesh belongs to it."""


def build_regions(section: Any, fitted: Fitted | None) -> Regions:
    """By name the faces of each region, `surface` first; nothing before a fit of fields.

    An entry has a `centre` [m] and a `radius` [m]: the faces whose centres lie within.

    Raises `InputError` for what is no region, holds no face, or is of no field.
    """
    if fitted is None or not fitted.varies:
        if section:
            raise InputError(
                "regions are of a field that was fitted", where="regions", value=section,
                limit="estimate=DIR of a fit with field=control_points, for example",
                remedy="leave regions out",
            )  # fmt: skip
        return {}
    if not isinstance(section or {}, Mapping) or SURFACE in (section or {}):
        raise InputError(
            "regions by name are wanted", where="regions", value=section,
            limit=f"{{tip: {{centre: [0,0,0.02], radius: 0.005}}}}, none of them called {SURFACE}",
            remedy="write 'regions={tip:{centre:[0,0,0.02],radius:0.005}}'",
        )  # fmt: skip
    mesh, *_ = load_estimate(fitted.folder / "estimate.npz")
    found = {SURFACE: np.ones(len(mesh.faces), bool)}
    for name, entry in (section or {}).items():
        centre, radius = _ball(f"regions.{name}", entry)
        inside = faces_where(
            mesh,
            lambda places, _, centre=centre, radius=radius: (
                np.linalg.norm(places - centre, axis=1) <= radius
            ),
            where=f"regions.{name}",
        )
        found[str(name)] = np.isin(np.arange(len(mesh.faces)), inside)
    return found


def _ball(where: str, entry: Any) -> tuple[np.ndarray, float]:
    """Centre [m] and radius [m]. Raises `InputError`."""
    try:
        if set(entry) != {"centre", "radius"}:
            raise ValueError
        centre = np.asarray(entry["centre"], dtype=float)
        if centre.shape != (3,) or not np.isfinite(centre).all():
            raise ValueError
    except (TypeError, ValueError) as fault:
        raise InputError(
            "a region has a centre and a radius", where=where, value=entry,
            limit="{centre: [x,y,z], radius: r} in metres", remedy="give both and nothing else",
        ) from fault  # fmt: skip
    return centre, number(entry, "radius", f"{where}.", above=0.0)


def region_means(
    left: FieldPosterior, regions: Regions, budget: float
) -> tuple[list[RegionMean], list[str]]:
    """The mean of each field over each region with its profile, and in words what was not made.

    Nothing is simulated once `budget` [s] is spent on them, and no profile is begun for which the
    rest of it cannot suffice; compiling is not counted.
    """
    means = [
        region_mean(left, name, region, inside)
        for region, inside in regions.items()
        for name in left.fields
    ]
    if budget <= 0 or left.loss is None:
        return means, [f"Profiles of means over regions: budget is {budget:g}."] if means else []
    if not means:
        return means, []
    plain = left.loss.of
    plain(left.loss.first)
    limit = TimeLimit(budget)
    watched = limit.watched(plain)
    watched(left.loss.first)
    left = replace(left, loss=replace(left.loss, of=watched))
    for place, mean in enumerate(means):
        try:
            limit.require(LEAST)
            made = region_profile(left, mean.quantity, regions[mean.region])
        except OutOfTime:
            which = ", ".join(f"{one.quantity} over {one.region}" for one in means[place:])
            takes = f"one profile takes {LEAST} or more"
            return means, [f"Profiles of means, {which}: {limit.words()}, {takes}."]
        means[place] = replace(mean, profile=made)
        words = f"profile of the mean of {mean.quantity} over {mean.region}: {made.kind}"
        print(words, file=sys.stderr)
    return means, []


def mean_sentences(means: list[RegionMean]) -> list[str]:
    """What the profiles of means say that slopes do not, in words."""
    told = []
    for mean in means:
        made, of = mean.profile, f"the mean of {mean.quantity} over {mean.region}"
        if made is None:
            continue
        ends = [
            "no end" if end is None else f"{np.exp(end):.4g}" for end in (made.lower, made.upper)
        ]
        if made.kind != "bounded":
            told.append(f"The profile of {of} is {made.kind}: {' to '.join(ends)}.")
        elif made.nonlinear():
            told.append(
                f"The profile of {of} ends at {' and '.join(ends)}, more than a fifth off what "
                "slopes alone foretell: take the profile."
            )
    return told

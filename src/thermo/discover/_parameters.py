"""The unknowns of the stated model, before and after what was found."""

from __future__ import annotations

from collections.abc import Mapping

import jax
import numpy as np

from thermo.discover._extended import Extended, moved, numbers
from thermo.discover._standing import Standing, free_of
from thermo.inverse import NORMAL, with_fields


def parameters(begun: Standing, last: Standing) -> dict[str, tuple[float, float]]:
    """The fields' values before and after [SI]."""
    before, after = (values(one, one.point) for one in (begun, last))
    return {name: (one, after[name]) for name, one in before.items()}


def values(standing: Standing, point: Extended) -> dict[str, float]:
    """One value of each field at a point [SI]."""
    fields = with_fields(standing.bench.coarse, point.fields)
    return {name: float(one.control_values()[0]) for name, one in fields.items()}


def parameter_intervals(standing: Standing) -> Mapping[str, tuple[float, float]]:
    """In which the fields' values where a fit ended are in 95 % of cases [SI].

    The errors are those of all that was fitted together, by noise and what is allowed for, widened
    by the misfit that is left. Of one field a parameter is the logarithm of its value or, at its
    bounds, nearly that: the ends are its values so many deviations away.

    Source: Seber and Wild, Nonlinear Regression (1989), section 5.1.
    """
    point, free, slopes = standing.point, free_of(standing), standing.ended.slopes
    covariance = np.linalg.pinv(slopes.T @ slopes, hermitian=True) * standing.misfit()
    deviation = np.sqrt(np.diag(covariance)) * free.scale
    at = numbers(point)
    found = {}
    for name, where in at.at.fields.items():
        (number,) = (int(one) for leaf in jax.tree.leaves(where) for one in np.ravel(leaf))
        change = np.zeros(at.count)
        change[number] = NORMAL * deviation[int(np.flatnonzero(free.number == number)[0])]
        low, high = (values(standing, moved(point, sign * change))[name] for sign in (-1, 1))
        found[name] = (low, high)
    return found

"""The mean of a field over a region of the surface: its interval by slopes, and its profile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, final

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.linalg import solve_triangular

from thermo.errors import InputError
from thermo.identify._path import LEVEL
from thermo.identify._profile import Profile, profile
from thermo.inverse import FieldPosterior
from thermo.mesh import face_areas

SURFACE: Final = "surface"
"""What the region is called that is all of the surface."""

# Added to every sum of squares, of which only differences count here: what is left of it beside
# the part along the slopes has to have a root, whatever a slope far from the estimate says [1].
_PAD: Final = 1e6


@final
@dataclass(frozen=True)
class RegionMean:
    """The mean of a field over a region, by area.

    - `quantity`: of the field; `region`: what it is called; `share`: its part of the surface [1].
    - `value`: of the estimate [SI]; `deviation`: of its logarithm about the estimate by slopes, as
      `FieldPosterior` tells it [1].
    - `profile`: of that logarithm; None where it was not made.
    """

    quantity: str
    region: str
    share: float
    value: float
    deviation: float
    profile: Profile | None = None


def region_mean(
    left: FieldPosterior, name: str, region: str, inside: Bool[np.ndarray, " faces"]
) -> RegionMean:
    """The mean of the estimate [SI] over the faces `inside`, and its interval by slopes [1].

    `region` is what they are called. Raises `InputError` where there is no such field, or no face.
    """
    mean = _mean(left, name, inside)
    value, slope = mean(np.zeros(len(left.covariance)))
    variance = float(slope @ left.covariance @ slope)
    share = float(left.shares() @ inside)
    return RegionMean(name, region, share, float(np.exp(value)), float(np.sqrt(variance)))


def region_profile(
    left: FieldPosterior,
    name: str,
    inside: Bool[np.ndarray, " faces"],
    *,
    level: float = LEVEL,
) -> Profile:
    """min over all fields of chi^2, for values of the log of a mean on both sides of the best.

    m(d) = log(sum of A phi_0 exp(E d) / sum of A), over the faces of the region with areas A. Where
    all d of that field rise by s, m rises by s, so that with e, d less its value at one control,

        d = e + (t - m(e)) 1

    meets m = t whatever e is: `profile` leads t and leaves e, and other fields, free. Sums of
    squares and their slopes are those of the simulation; steps are Gauss-Newton's with the
    curvature at the estimate, J'J of the data with what is believed and smooth. What they still
    promise is told from the true slope, and so a path that has not settled is seen.

    Arguments:

    - `left`: what the data leave open of fields [1], with its `loss`.
    - `name`: of the field; `inside`: whether a face belongs to the region, (faces,).
    - `level`: rise of chi squared at the ends of the interval [1], 3.84 for 95 %.

    The smoothness is the one that is most probable; errors of cells and steps that are left count
    for nothing: the deviation of `region_mean` has both, `Profile.linear` neither.

    Raises `InputError` where there is no such field, no face, or no loss.

    Source: Raue et al., Bioinformatics 25 (2009) 1923; the constraint, Bates and Watts, Nonlinear
    Regression Analysis (1988), section 6.1.2.
    """
    mean = _mean(left, name, inside)
    if left.loss is None:
        raise InputError(
            "nothing can be fitted anew beside this posterior", where="left.loss", value=None,
            limit="what `thermo.inverse.posterior` returns", remedy="take it as it was returned",
        )  # fmt: skip
    model = _Along(left.loss.of, mean, left.loss.curvature)
    start = model.coordinates(left.loss.first)
    bounds = np.tile([-np.inf, np.inf], (len(start), 1))
    quantity = left.fields[name].quantity
    bounds[0] = np.log([quantity.lower, quantity.upper])
    return profile(model, start, 0, bounds=bounds, level=level)


@final
@dataclass(frozen=True)
class _Mean:
    """Logarithm of a mean at departures d [1].

    - `weights`: A phi_0 over the sum of A, (faces,) [SI]; `onto`: E there, (faces, controls) [1].
    - `part`: where d of the field is among all; `count`: of all [1].
    """

    weights: Float[np.ndarray, " faces"]
    onto: Float[np.ndarray, "faces controls"]
    part: slice
    count: int

    def __call__(
        self, departures: Float[np.ndarray, " unknowns"]
    ) -> tuple[float, Float[np.ndarray, " unknowns"]]:
        """The logarithm [log SI] and its slopes [1], which sum to 1."""
        logs = np.log(self.weights) + self.onto @ departures[self.part]
        highest = logs.max()
        grown = np.exp(logs - highest)
        slope = np.zeros(self.count)
        slope[self.part] = grown @ self.onto / grown.sum()
        return float(highest + np.log(grown.sum())), slope


def _mean(left: FieldPosterior, name: str, inside: Bool[np.ndarray, " faces"]) -> _Mean:
    if name not in left.fields or not np.any(inside):
        raise InputError(
            "there is no field of that name" if name not in left.fields else "no face is inside",
            where="name" if name not in left.fields else "inside",
            value=name if name not in left.fields else f"0 of {len(left.mesh.faces)} faces",
            limit=", ".join(left.fields), remedy="name a fitted field and a part of its surface",
        )  # fmt: skip
    areas = face_areas(left.mesh)[inside]
    values = np.asarray(left.fields[name].face_values())[inside]
    onto = left.onto_faces(name)[inside]
    return _Mean(areas / areas.sum() * values, onto, left.part(name), len(left.shift))


@final
@dataclass
class _Along:
    """`loss` as a residual in (t, e), e without its value at one control, where it is zero [1].

    The residual is (L^-1 slope, rest), LL' = `curvature`: its square is chi^2 but for a constant,
    and its slopes, with those of the rest left out, lead to the true slope of half of it.
    """

    loss: Callable[[np.ndarray], tuple[float, np.ndarray]]
    mean: _Mean
    curvature: Float[np.ndarray, "unknowns unknowns"]
    root: Float[np.ndarray, "unknowns unknowns"] = field(init=False)
    free: Int[np.ndarray, " others"] = field(init=False)
    ones: Float[np.ndarray, " unknowns"] = field(init=False)

    def __post_init__(self) -> None:
        """Choose the control at which e is zero: that which counts most in the mean."""
        self.root = np.linalg.cholesky(self.curvature)
        _, slope = self.mean(np.zeros(self.mean.count))
        self.free = np.delete(np.arange(self.mean.count), int(np.argmax(slope)))
        self.ones = np.zeros(self.mean.count)
        self.ones[self.mean.part] = 1.0

    def coordinates(
        self, departures: Float[np.ndarray, " unknowns"]
    ) -> Float[np.ndarray, " unknowns"]:
        """t [log SI] and e [1] of departures."""
        (held,) = np.setdiff1d(np.arange(self.mean.count), self.free)
        value, _ = self.mean(departures)
        apart = departures - departures[held] * self.ones
        return np.concatenate([[value], apart[self.free]])

    def __call__(
        self, unknowns: Float[np.ndarray, " unknowns"]
    ) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values unknowns"]]:
        """Residual [1] and its slopes [1]."""
        apart = np.zeros(self.mean.count)
        apart[self.free] = unknowns[1:]
        value, slope = self.mean(apart)
        square, half = self.loss(apart + (unknowns[0] - value) * self.ones)
        change = np.eye(self.mean.count)[:, self.free] - np.outer(self.ones, slope[self.free])
        change = np.column_stack([self.ones, change])
        along = solve_triangular(self.root, half, lower=True)
        rest = np.sqrt(max(_PAD + square - float(along @ along), 0.0))
        matrix = np.vstack([self.root.T @ change, np.zeros(len(unknowns))])
        return np.append(along, rest), matrix

"""How long the cameras' unit is."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from thermo.errors import InputError
from thermo.observe import check_number

_TUKEY: Final = 4.685
"""Deviations at which Tukey's weights fall to nothing [1]: 95 % efficient for normal errors."""
_NORMAL: Final = 1.4826
"""A normal error's deviation over its median size [1]."""
_ROUNDS: Final = 50
"""How often weights are computed anew [1]."""


class MetricScale(NamedTuple):
    """Metres a unit.

    - `factor`: length of the cameras' unit [m].
    - `deviation`: one standard deviation of it over it [1]. Diffusion times go with lengths
      squared, so that a diffusivity from this surface has twice as much.
    - `source`: what it was taken from, in words.
    """

    factor: float
    deviation: float
    source: str


def scale_from_length(
    first: Float[np.ndarray, "3"],
    second: Float[np.ndarray, "3"],
    metres: float,
    deviation: float,
) -> MetricScale:
    """From the known distance of two places.

    Arguments:

    - `first`, `second`: in the cameras' unit [1].
    - `metres`: how far they are apart [m]. `deviation`: one standard deviation of that [m].

    Raises `InputError` for places that coincide and lengths that are none.
    """
    remedy = "give the length in metres, and how far off it may be"
    metres = check_number(
        metres, where="scale.length.metres", quantity="length [m]", above=0.0, remedy=remedy
    )
    deviation = check_number(
        deviation, where="scale.length.deviation", quantity="deviation of the length [m]",
        least=0.0, most=metres, remedy=remedy,
    )  # fmt: skip
    apart = float(np.linalg.norm(np.asarray(second, float) - first))
    if not np.isfinite(apart) or apart == 0.0:
        raise InputError(
            "these places have no distance", where="scale.length", value=apart,
            limit="two places that differ", remedy="give from and to in the cameras' unit",
        )  # fmt: skip
    return MetricScale(metres / apart, deviation / metres, "a known length")


def scale_from_distances(
    places: Float[np.ndarray, "cameras 3"],
    pairs: Int[np.ndarray, "pairs 2"],
    metres: Float[np.ndarray, " pairs"],
) -> MetricScale:
    """From known distances of cameras, at least three, of which a few may be wrong.

    Arguments: `places` of the cameras in their unit [1]; `pairs` of them, and how far each two are
    apart [m].

    Raises `InputError` for fewer than three pairs, and for distances that are none.

    Source: as `scale_from_depths`; errors of pairs count as independent.
    """
    apart = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    return _from_ratios(
        metres, apart, np.arange(len(pairs)), "scale.cameras", "distances of cameras"
    )


def scale_from_depths(
    measured: Float[np.ndarray, " pixels"],
    rebuilt: Float[np.ndarray, " pixels"],
    group: Int[np.ndarray, " pixels"],
) -> MetricScale:
    """From depths that something else measured.

    Arguments:

    - `measured`: depths of pixels [m]. `rebuilt`: of the same in the cameras' unit [1]. Pixels in
      which either is not finite or not positive count for nothing.
    - `group`: of pixels whose errors may be alike, such as those of one picture; errors of
      different groups are independent.

    Raises `InputError` where fewer than three groups have pixels.

    Source: Tukey's location of the ratios (Beaton and Tukey, Technometrics 16 (1974) 147), with the
    deviation of Liang and Zeger, Biometrika 73 (1986) 13, by groups.
    """
    with np.errstate(invalid="ignore"):
        known = np.isfinite(measured) & np.isfinite(rebuilt) & (measured > 0) & (rebuilt > 0)
    return _from_ratios(measured[known], rebuilt[known], group[known], "scale.depths", "depths")


def _from_ratios(
    metres: Float[np.ndarray, " values"],
    units: Float[np.ndarray, " values"],
    group: Int[np.ndarray, " values"],
    where: str,
    what: str,
) -> MetricScale:
    """Tukey's location of the ratios, and its deviation from the scatter between groups.

    With psi_i of the ratio q_i: sum psi_i = 0, and var = G/(G-1) sum_g (sum_{i in g} psi_i)^2 /
    (sum psi'_i)^2, which holds however errors within a group go together.

    Source: Beaton and Tukey, Technometrics 16 (1974) 147; Huber, Robust Statistics (1981),
    chapters 4 and 6; Liang and Zeger, Biometrika 73 (1986) 13.
    """
    groups, label = np.unique(group, return_inverse=True)
    wrong = ~(np.isfinite(metres) & np.isfinite(units) & (metres > 0) & (units > 0))
    if len(groups) < 3 or wrong.any():
        raise InputError(
            f"these {what} give no scale", where=where,
            value=f"{len(groups)} of them" + (", some not above 0" if wrong.any() else ""),
            limit="three and more above 0: fewer do not say how far off they are",
            remedy="measure more, or give scale.length with its deviation",
        )  # fmt: skip
    ratio = metres / units
    centre = float(np.median(ratio))
    # Ratios that agree to rounding have no scatter to divide by.
    spread = max(_NORMAL * float(np.median(np.abs(ratio - centre))), 1e-12 * centre)
    for _ in range(_ROUNDS):
        part = (ratio - centre) / (_TUKEY * spread)
        weight = np.where(np.abs(part) < 1.0, (1.0 - part**2) ** 2, 0.0)
        centre = float((weight * ratio).sum() / weight.sum())
    part = (ratio - centre) / (_TUKEY * spread)
    inside = np.abs(part) < 1.0
    pull = np.where(inside, part * (1.0 - part**2) ** 2, 0.0) * _TUKEY * spread
    slope = np.where(inside, (1.0 - part**2) * (1.0 - 5.0 * part**2), 0.0).sum()
    sums = np.bincount(label, pull, len(groups))
    variance = len(groups) / (len(groups) - 1) * float((sums**2).sum()) / slope**2
    source = f"{len(ratio)} {what}"
    return MetricScale(centre, float(np.sqrt(variance)) / centre, source)

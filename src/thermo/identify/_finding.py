"""A verdict on each unknown, from the spectrum of what the data say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.identify._information import bounds_of, pulls
from thermo.identify._spectrum import Spectrum
from thermo.inverse import NORMAL, Sensitivity

Verdict = Literal["identified", "weak", "not_identified", "at_bound"]
"""What is said of an unknown."""

FACTOR_TWO: Final = float(np.log(2.0))
"""Half-width of log(phi) [1] beyond which a value is not known to a factor of two."""

_AT_BOUND: Final = 1e-3
"""Distance of log(phi) from a bound [1] at which a value stands on it."""


@final
@dataclass(frozen=True)
class Finding:
    """What data and prior say of one unknown.

    - `name`; `unit`; `value` in it, for several values of one quantity their geometric mean.
    - `relative`: standard deviation of log(value) [1]; `sd`: of the value, `value * relative`.
    - `interval95`: of the value, within its bounds, in its unit.
    - `informed`: share of the prior's variance that the data take away [1].
    - `verdict`: "identified" where the data lead and the 95 % interval stays within what is
      wanted; "weak" where it is wider and yet within a factor of two, and the data lead;
      "at_bound" where the value stands on a bound; else "not_identified".
    """

    name: str
    unit: str
    value: float
    relative: float
    sd: float
    interval95: tuple[float, float]
    informed: float
    verdict: Verdict


def findings(
    at: Sensitivity, found: Spectrum, *, wanted: float = 0.1, model_error: float = 0.01
) -> list[Finding]:
    """A verdict on each unknown.

    Where `at` holds what cells and steps still make wrong, the move that it causes in a fit that
    does not know of it, b = C J'C^-1 d for each run, counts as an error of its own: C + b b'. So
    does what one standard deviation of the surface's scale moves, where it is not exact.

    Arguments:

    - `at`: slopes [K], with the values where they were taken; `found`: their spectrum [1].
    - `wanted`: half-width of the 95 % interval of log(value) that counts as known [1].
    - `model_error`: what the simulation itself may be wrong by [K], as for the spectrum.

    A value that the prior alone makes narrow is not identified: the data must take away at least
    half of its variance, and more than half of what is left must be the data's own noise and not
    a direction that is the prior's.

    Raises `InputError` where `wanted` is not above 0.
    """
    check_wanted(wanted)
    moved = found.covariance() @ pulls(at, model_error)
    return [_finding(at, found, moved, name, wanted) for name in dict.fromkeys(at.names)]


def check_wanted(wanted: float) -> None:
    """Refuse half-widths of an interval [1] that cannot be. Raises `InputError`."""
    if not (np.isfinite(wanted) and wanted > 0):
        raise InputError(
            "an interval cannot be this narrow", where="wanted", value=wanted,
            limit="a finite number above 0", remedy="give 0.1 for 10 %",
        )  # fmt: skip


def _finding(
    at: Sensitivity,
    found: Spectrum,
    moved: Float[np.ndarray, "unknowns causes"],
    name: str,
    wanted: float,
) -> Finding:
    mine = np.array([other == name for other in at.names])
    mean = mine / mine.sum()
    known, along = found.known(), mean @ found.directions
    before, after = float(np.sum(along**2)), float(np.sum(along**2 * (1 - known)))
    led = np.arange(len(known)) < found.data_led()
    prior_left = float(np.sum((along**2 * (1 - known))[~led])) / after
    after = min(after + float(np.sum((mean @ moved) ** 2)), before)
    middle, informed = float(mean @ np.log(at.values)), 1 - after / before
    seen = informed > 0.5 and prior_left < 0.5
    return finding(name, middle, float(np.sqrt(after)), informed, wanted, led=seen)


def finding(
    name: str, middle: float, relative: float, informed: float, wanted: float, *, led: bool
) -> Finding:
    """What is said of one unknown.

    Arguments: log(value) `middle`, its deviation `relative`, the share `informed` of the prior's
    variance, the half-width `wanted`, all [1]; `led`: whether the data lead.
    """
    unit = QUANTITIES[name].unit if name in QUANTITIES else "1"
    low, high = np.log(bounds_of(name))
    ends = np.exp(np.clip([middle - NORMAL * relative, middle + NORMAL * relative], low, high))
    on_bound = bool(min(middle - low, high - middle) < _AT_BOUND)
    return Finding(
        name=name,
        unit=unit,
        value=float(np.exp(middle)),
        relative=relative,
        sd=float(np.exp(middle)) * relative,
        interval95=(float(ends[0]), float(ends[1])),
        informed=informed,
        verdict=_verdict(NORMAL * relative, wanted, led, on_bound),
    )


def _verdict(half: float, wanted: float, led: bool, on_bound: bool) -> Verdict:
    if on_bound:
        return "at_bound"
    if not led or half > max(FACTOR_TWO, wanted):
        return "not_identified"
    return "identified" if half <= wanted else "weak"

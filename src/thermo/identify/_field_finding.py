"""A verdict on the mean of each field over the surface."""

from __future__ import annotations

import numpy as np

from thermo.identify._finding import Finding, check_wanted, finding
from thermo.inverse import NORMAL, FieldPosterior


def field_findings(left: FieldPosterior, *, wanted: float = 0.1) -> list[Finding]:
    """What data and prior say of the geometric mean of each field over the surface, by area.

    Arguments:

    - `left`: what the data leave open of the fields [1].
    - `wanted`: half-width of the 95 % interval of log(mean) that counts as known [1].

    Raises `InputError` where `wanted` is not above 0.
    """
    check_wanted(wanted)
    made = []
    for name in left.fields:
        middle, after, before = left.mean(name)
        informed = 1 - (after / before) ** 2
        made.append(finding(name, middle, after, informed, wanted, led=informed > 0.5))
    return made


def field_sentences(left: FieldPosterior) -> list[str]:
    """How well each field is known from place to place, in words."""
    told = []
    for name in left.fields:
        half, most = np.expm1(NORMAL * np.quantile(left.deviation(name), [0.5, 0.95]))
        dark = float(left.shares() @ (left.informed(name) < 0.5))
        length = 1e3 * float(np.median(left.resolution(name)))
        told.append(
            f"From place to place {name} is known to {100 * half:.2g} % on half of the faces and "
            f"to {100 * most:.2g} % on 95 % of them (95 % bands); a value there is one of some "
            f"{length:.2g} mm around. On {dark:.0%} of the surface what a place differs by from "
            "the mean is known from its neighbours more than from the readings."
        )
    return told

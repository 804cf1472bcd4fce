"""Standings of a search made by hand, as far as its rules look at them."""

from __future__ import annotations

import numpy as np

from thermo.discover._allowance import Allowance
from thermo.discover._bench import Bench
from thermo.discover._descent import Ended
from thermo.discover._entries import Active
from thermo.discover._extended import Extended
from thermo.discover._softening import Block
from thermo.discover._standing import Standing

FRAMES, SAMPLES = 8, 5
VALUES = FRAMES * SAMPLES
NOTHING = Extended({}, ())


def standing(
    left: float, free: int, smooth: float = 1.0, active: tuple[Active, ...] = ()
) -> Standing:
    """One that leaves a residual of this sum of squares, and this variance of smooth shapes."""
    across, along = np.eye(SAMPLES)[:, :1], np.eye(FRAMES)[:, :1]
    block = Block("run", slice(0, VALUES), (FRAMES, SAMPLES), along, across, 0.0, 1.05, VALUES)
    residual = np.full(VALUES, np.sqrt((left - smooth) / (VALUES - 1)))
    residual[0] = np.sqrt(smooth)
    made = object.__new__(Standing)
    allowed = Allowance([block], np.zeros((VALUES, 0)), np.zeros(0))
    for name, value in [
        ("ended", Ended(NOTHING, residual, np.zeros((VALUES, free)))), ("allowed", allowed),
        ("active", active), ("point", NOTHING), ("bench", object.__new__(Bench)), ("first", {}),
        ("held", {}),
    ]:  # fmt: skip
        object.__setattr__(made, name, value)
    return made

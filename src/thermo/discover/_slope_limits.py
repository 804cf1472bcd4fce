"""How steeply a property may change with temperature and be one at all that was read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import jax.numpy as jnp
import numpy as np

from thermo.observe import REFERENCE, Run
from thermo.physics.effects import AbstractLaw

LEFT: Final = 0.1
"""Of a stated property what is left of it at any temperature, at the least [1]."""


def slope_limits(law: AbstractLaw | None, runs: Sequence[Run]) -> tuple[float, float]:
    """The least and the largest strength of f(T) + strength (T - 293.15 K) [1/K].

    Where a conductivity or a capacity falls below zero heat gathers in place of spreading, and the
    equation has no solution that depends on what is stated: cells that are small enough burst. At
    all temperatures that runs begin with, prescribe or read a tenth of f is left.

    Arguments: `law`: f, None where it is one.

    Source: Friedman, Partial Differential Equations of Parabolic Type (1964), chapter 1, section 1.
    """
    read = np.concatenate([_temperatures(run) for run in runs])
    low, high = -np.inf, np.inf
    for one in (float(read.min()), float(read.max())):
        stated = 1.0 if law is None else float(law.factor(jnp.asarray(one)))
        end = -(1 - LEFT) * stated / (one - REFERENCE) if one != REFERENCE else np.inf
        low, high = (max(low, end), high) if one > REFERENCE else (low, min(high, end))
    return low, high


def _temperatures(run: Run) -> np.ndarray:
    record = run.recording
    told = [np.ravel(one.temperature) for one in run.prescribed]
    return np.concatenate([[run.initial_temperature], record.temperature[record.valid], *told])

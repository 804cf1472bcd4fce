"""Temperatures between the steps of a simulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline


def between_steps(
    time: Float[np.ndarray, " steps"],
    temperature: Float[np.ndarray, "steps samples"],
    frames: Float[np.ndarray, " frames"],
    switches: Sequence[float] = (),
) -> Float[np.ndarray, "frames samples"]:
    """Temperatures at frames, by cubic splines through what the steps ended at.

    A spline is of fourth order where the steps are of second, so that steps may be as long as
    their own error allows, however many frames lie in between. It never runs across a switch,
    where the slope jumps.

    Arguments:

    - `time`: ends of the steps and the start, (steps,) [s]; `temperature`: (steps, samples) [K].
    - `frames`: (frames,) [s], within `time`.
    - `switches`: times at which sources jump, each the end of a step [s].

    Source: de Boor, A Practical Guide to Splines, chapter IV.
    """
    inside = [moment for moment in switches if time[0] < moment < time[-1]]
    bounds = np.array([time[0], *sorted(inside), time[-1]])
    result = np.empty((len(frames), temperature.shape[1]))
    for low, high in zip(bounds[:-1], bounds[1:], strict=True):
        here = (time >= low - 1e-9) & (time <= high + 1e-9)
        wanted = (frames >= low - 1e-9) & (frames <= high + 1e-9)
        result[wanted] = CubicSpline(time[here], temperature[here])(frames[wanted])
    return result

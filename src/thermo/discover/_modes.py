"""Smooth shapes in space and time, in which what no noise makes would show."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float
from scipy.spatial.distance import pdist, squareform

# Smooth shapes in time and over the samples [1], and their range over the body's longest side [1].
IN_TIME: Final = 12
IN_SPACE: Final = 16
_RANGE: Final = 0.3


def time_modes(frames: int) -> Float[np.ndarray, "frames modes"]:
    """Cosines, orthonormal over the frames [1]."""
    count = min(IN_TIME, frames)
    number, frame = np.arange(count), np.arange(frames)
    made = np.cos(np.pi / frames * np.outer(frame + 0.5, number))
    return made / np.sqrt((made**2).sum(0))


def space_modes(points: Float[np.ndarray, "samples 3"]) -> Float[np.ndarray, "samples modes"]:
    """The smoothest shapes over points [m], orthonormal over them [1].

    Those along which values with a covariance exp(-r^2 / (2 l^2)) vary most, r straight through
    the body.
    """
    count = min(IN_SPACE, len(points))
    # Samples at one place have one shape.
    reach = max(_RANGE * float(np.ptp(points, axis=0).max()), np.finfo(float).tiny ** 0.25)
    near = np.exp(-(squareform(pdist(points)) ** 2) / (2 * reach**2))
    values, vectors = np.linalg.eigh(near)
    return vectors[:, np.argsort(values)[::-1][:count]]

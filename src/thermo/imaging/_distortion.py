"""Lens distortion of Brown and Conrady: three radial and two tangential coefficients."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

_STEPS: Final = 50
"""Newton steps at the most [1]."""


def distorted(
    flat: Float[np.ndarray, "*points 2"], coefficients: Float[np.ndarray, "5"]
) -> Float[np.ndarray, "*points 2"]:
    """Where a lens brings what an ideal one would bring to `flat`, both over the focal length [1].

    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' with x and y, p1 and
    p2 exchanged. Arguments: `coefficients` k1, k2, p1, p2, k3 [1], in OpenCV's order.

    Source: Brown, Photogrammetric Engineering 32 (1966) 444; OpenCV, camera calibration.
    """
    x, y = flat[..., 0], flat[..., 1]
    radial, _, tangent = _parts(x, y, coefficients)
    return np.stack([x * radial + tangent[0], y * radial + tangent[1]], axis=-1)


def undistorted(
    bent: Float[np.ndarray, "*points 2"], coefficients: Float[np.ndarray, "5"]
) -> Float[np.ndarray, "*points 2"]:
    """The inverse of `distorted` [1], by Newton's method; NaN where a lens brings nothing there.

    A strong lens folds its picture over far from the middle: only what Newton's method reaches from
    `bent` itself is given back.
    """
    if not np.any(coefficients):
        return bent
    flat = bent.copy()
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            off = distorted(flat, coefficients) - bent
            if not np.nanmax(np.abs(off), initial=0.0) > 1e-15:
                break
            flat = flat - np.linalg.solve(_jacobian(flat, coefficients), off[..., None])[..., 0]
        off = np.abs(distorted(flat, coefficients) - bent).max(-1)
    scale = 1.0 + np.abs(bent).max(-1)
    return np.where((off < 1e-12 * scale)[..., None], flat, np.nan)


def _jacobian(flat: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    x, y = flat[..., 0], flat[..., 1]
    p1, p2 = coefficients[2], coefficients[3]
    radial, slope, _ = _parts(x, y, coefficients)
    cross = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y
    first = radial + 2 * x**2 * slope + 2 * p1 * y + 6 * p2 * x
    second = radial + 2 * y**2 * slope + 6 * p1 * y + 2 * p2 * x
    rows = [np.stack([first, cross], -1), np.stack([cross, second], -1)]
    return np.stack(rows, -2)


def _parts(
    x: np.ndarray, y: np.ndarray, coefficients: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Radial factor, its slope by r^2, and the tangential shift."""
    k1, k2, p1, p2, k3 = coefficients
    square = x**2 + y**2
    radial = 1 + square * (k1 + square * (k2 + square * k3))
    slope = k1 + square * (2 * k2 + 3 * square * k3)
    tangent = (2 * p1 * x * y + p2 * (square + 2 * x**2), p1 * (square + 2 * y**2) + 2 * p2 * x * y)
    return radial, slope, tangent


def unknown_lens(where: str, model: str, limit: str, *, fisheye: bool = False) -> InputError:
    """The error for a lens that these coefficients do not hold.

    Arguments: `where` it is stated; its `model`; the `limit`, models that are known; whether it is
    a `fisheye`, whose angles and not their tangents are bent.
    """
    remedy = "rectify pictures and calibration first, for example with COLMAP's image_undistorter"
    what = "this lens is not known"
    if fisheye or "FISHEYE" in model.upper():
        what = "this lens is a fisheye"
        remedy += ", frames of a thermal camera with OpenCV's fisheye.undistortImage"
    return InputError(what, where=where, value=model, limit=limit, remedy=remedy)

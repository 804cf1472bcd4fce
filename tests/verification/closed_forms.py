"""Series solutions of Carslaw and Jaeger, Conduction of Heat in Solids, second edition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

TERMS = 200


def _roots(function: Callable[[float], float], low: float, high: float) -> np.ndarray:
    """The root of `function` in each interval (n pi + low, n pi + high)."""
    tiny = 1e-12
    return np.array(
        [brentq(function, n * np.pi + low + tiny, n * np.pi + high - tiny) for n in range(TERMS)]
    )


def convective_slab(
    x: np.ndarray, time: np.ndarray, *, length: float, diffusivity: float, biot: float
) -> np.ndarray:
    """Share of the first excess left at (time, x) when x = length exchanges, x = 0 does not."""
    z = _roots(lambda z: z * np.sin(z) - biot * np.cos(z), 0.0, np.pi / 2)
    factor = 4 * np.sin(z) / (2 * z + np.sin(2 * z))
    decay = np.exp(-(z**2) * (diffusivity / length**2) * np.asarray(time)[:, None])
    return (decay * factor) @ np.cos(np.outer(z, np.asarray(x) / length))


def step_slab(x: np.ndarray, time: np.ndarray, *, length: float, diffusivity: float) -> np.ndarray:
    """Share of the first excess left when x = length goes to zero at once, x = 0 adiabatic."""
    z = (np.arange(TERMS) + 0.5) * np.pi
    factor = 2 * (-1.0) ** np.arange(TERMS) / z
    decay = np.exp(-(z**2) * (diffusivity / length**2) * np.asarray(time)[:, None])
    return (decay * factor) @ np.cos(np.outer(z, np.asarray(x) / length))


def flux_slab(x: np.ndarray, time: np.ndarray, *, length: float, diffusivity: float) -> np.ndarray:
    """Rise over flux * length / conductivity at (time, x), flux at x = length, x = 0 adiabatic."""
    share = np.asarray(x) / length
    fourier = (diffusivity / length**2) * np.asarray(time)[:, None]
    z = np.arange(1, TERMS) * np.pi
    factor = 2 * (-1.0) ** np.arange(1, TERMS) / z**2
    rest = (np.exp(-(z**2) * fourier) * factor) @ np.cos(np.outer(z, share))
    return fourier + (3 * share**2 - 1) / 6 - rest


def sine_driven_slab(
    x: float, time: float, *, length: float, diffusivity: float, omega: float
) -> float:
    """Temperature over the amplitude when x = length follows sin(omega t) and x = 0 is held."""
    n = np.arange(1, TERMS)
    rate = diffusivity * (n * np.pi / length) ** 2
    share = 2 * (-1.0) ** n / (n * np.pi)  # of minus x / length in sin(n pi x / length)
    cosine = rate * np.cos(omega * time) + omega * np.sin(omega * time)
    integral = (cosine - rate * np.exp(-rate * time)) / (rate**2 + omega**2)
    modes = omega * share * integral
    steady = np.sin(omega * time) * x / length
    return float(steady + modes @ np.sin(n * np.pi * x / length))


def convective_ball_centre(
    time: np.ndarray, *, radius: float, diffusivity: float, biot: float
) -> np.ndarray:
    """Share of the first excess left at the centre of a ball whose surface exchanges."""
    z = _roots(lambda z: np.sin(z) * (1 - biot) - z * np.cos(z), 0.0, np.pi)
    factor = 4 * (np.sin(z) - z * np.cos(z)) / (2 * z - np.sin(2 * z))
    return np.exp(-(z**2) * (diffusivity / radius**2) * np.asarray(time)[:, None]) @ factor


def plate_with_two_convective_sides(
    x: float, y: float, *, width: float, height: float, biot: float
) -> float:
    """Steady share of the base's excess at (x, y): base y = 0 held, x = 0 adiabatic.

    The sides x = width and y = height exchange; `biot` is h width / k.
    """
    z = _roots(lambda z: z * np.sin(z) - biot * np.cos(z), 0.0, np.pi / 2)
    factor = 4 * np.sin(z) / (2 * z + np.sin(2 * z))
    left = z * (height - y) / width
    # Ratio of (z cosh + biot sinh) at y and at the base, free of overflow.
    whole = z * height / width
    above = (z + biot) + (z - biot) * np.exp(-2 * left)
    below = (z + biot) + (z - biot) * np.exp(-2 * whole)
    return float((factor * np.cos(z * x / width) * np.exp(left - whole)) @ (above / below))


def two_layer_wall(
    x: np.ndarray, *, lengths: tuple[float, float], conductivities: tuple[float, float]
) -> np.ndarray:
    """Steady share of the drop from x = 0 to x = sum of lengths, across two layers in series."""
    first, second = (a / k for a, k in zip(lengths, conductivities, strict=True))
    x = np.asarray(x)
    passed = np.where(
        x < lengths[0], x / conductivities[0], first + (x - lengths[0]) / conductivities[1]
    )
    return passed / (first + second)

"""The integral of Planck's law over a part of the spectrum, without dimensions."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from jaxtyping import Float
from scipy.special import zeta

_SPLIT: Final = 2.0
"""Below it the power series is taken, from it on the exponential one [1]."""

_LEFT_OUT: Final = 1e-17
"""What either series leaves out, over its first term [1]."""

_ALL: Final = math.pi**4 / 15.0
"""The integral over the whole spectrum [1]."""


def planck_integral(
    low: Float[np.ndarray, "*shape"], high: Float[np.ndarray, "*shape"]
) -> Float[np.ndarray, "*shape"]:
    """The integral of t^3 / (exp(t) - 1) from `low` to `high` [1], 0 < low <= high.

    From x = 2 on, the integral from x to infinity is a sum over n of
    exp(-n x) (x^3/n + 3 x^2/n^2 + 6 x/n^3 + 6/n^4). Its terms fall at least by exp(-x), so that
    1 + 39/x of them leave out less than 1e-17 of the first. Below x = 2 the integral from 0 to x is
    x^3 (1/3 - x/8 + sum over k of B_2k x^2k / ((2k + 3) (2k)!)), B_2k being Bernoulli's numbers;
    its terms fall by (x / 2 pi)^2, one tenth or less, and 17 do. What is left is rounding: 1e-16 of
    the larger of the two integrals that are taken from each other.

    Source: Chang and Rhee, International Communications in Heat and Mass Transfer 11 (1984) 451;
    Modest, Radiative Heat Transfer, section 1.4.
    """
    first, last = np.atleast_1d(low), np.atleast_1d(high)
    with np.errstate(all="ignore"):
        part = _beyond(first) - _beyond(last)
        near = last < _SPLIT
        if near.any():
            part = np.where(near, _before(last) - _before(first), part)
    return part.reshape(low.shape)


def _beyond(x: np.ndarray) -> np.ndarray:
    """From x to infinity."""
    near = x < _SPLIT
    if not near.any():
        return _exponential_series(x)
    return np.where(near, _ALL - _before(x), _exponential_series(np.maximum(x, _SPLIT)))


def _exponential_series(x: np.ndarray) -> np.ndarray:
    least = float(np.fmin.reduce(x, axis=None, initial=np.inf))
    terms = math.ceil(1.0 - math.log(_LEFT_OUT) / max(least, _SPLIT))
    q = np.exp(-x)
    second, third, fourth = (_power_series(q, order, terms) for order in (2, 3, 4))
    return ((x * -np.log1p(-q) + 3.0 * second) * x + 6.0 * third) * x + 6.0 * fourth


def _power_series(q: np.ndarray, order: int, terms: int) -> np.ndarray:
    """The sum of q^n / n^order over n from 1 to `terms`, the polylogarithm."""
    total = np.full_like(q, terms ** -float(order))
    for n in range(terms - 1, 0, -1):
        total *= q
        total += n ** -float(order)
    return total * q


def _before(x: np.ndarray) -> np.ndarray:
    """From 0 to x, meant for x below 2."""
    x = np.minimum(x, _SPLIT)
    square = x**2
    total = np.zeros_like(x)
    for coefficient in _BERNOULLI[::-1]:
        total = total * square + coefficient
    return x**3 * (1.0 / 3.0 - x / 8.0 + total * square)


def _bernoulli_terms() -> np.ndarray:
    """B_2k / ((2k)! (2k + 3)) for k from 1 on.

    B_2k is 2 (-1)^(k+1) (2k)! zeta(2k) / (2 pi)^2k.
    """
    order = 2.0 * np.arange(1, math.ceil(math.log(_LEFT_OUT) / math.log(0.102)) + 1)
    sign = np.where(order % 4 == 2, 1.0, -1.0)
    return 2.0 * sign * zeta(order) / (2.0 * math.pi) ** order / (order + 3.0)


_BERNOULLI: Final = _bernoulli_terms()

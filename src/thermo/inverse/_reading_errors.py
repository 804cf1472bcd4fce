"""Errors of readings that are not independent: they fade from frame to frame, or they stay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.inverse._common_errors import (
    CommonErrors,
    common_errors,
    with_common_errors,
    without_common_errors,
)


@final
class ReadingErrors(eqx.Module):
    """The error of a reading as a sum of these, each of mean zero and independent of the others.

    - `own`: variance of what each reading has by itself, (frames, samples) [K2].
    - `fading`: variance of what fades from frame to frame [K2], and `kept`, the share of its value
      that is left since the frame before, (frames,) [1].
    - `staying`: variance of what each sample keeps over all frames, (samples,) [K2].
    - `common`: what all samples have in common; None where they have nothing.
    """

    own: Float[Array, "*runs frames samples"]
    fading: Float[Array, "*runs"]
    kept: Float[Array, "*runs frames"]
    staying: Float[Array, "*runs samples"]
    common: CommonErrors | None = None

    def variance(self) -> Float[Array, "*runs frames samples"]:
        """Of each reading [K2]."""
        alone = self.own + self.fading[..., None, None] + self.staying[..., None, :]
        return alone if self.common is None else alone + self.common.variance()[..., None, None]


def without(
    shared: Float[Array, "frames samples"], white: Float[Array, "frames samples"]
) -> Float[Array, "frames samples"]:
    """(I + D D')^-1/2 times whitened differences [1], D an error that all readings share.

    Its amplitude is unknown, of mean zero and variance one: `shared` is D, itself whitened [1].

    Source: the square root of the Sherman-Morrison formula.
    """
    square = jnp.sum(shared**2)
    share = (1 - 1 / jnp.sqrt(1 + square)) / jnp.where(square > 0, square, 1)
    return white - share * shared * jnp.sum(shared * white)


def with_again(
    shared: Float[Array, "frames samples"], freed: Float[Array, "frames samples"]
) -> Float[Array, "frames samples"]:
    """(I + D D')^1/2 times values [1], the inverse of `without`."""
    square = jnp.sum(shared**2)
    share = (jnp.sqrt(1 + square) - 1) / jnp.where(square > 0, square, 1)
    return freed + share * shared * jnp.sum(shared * freed)


Rule = Callable[[Array, Array, Array], tuple[Array, Array]]
"""From a value, what is expected of the difference [K] and the deviation of that [K]: what comes
as a surprise [K], and what is asked for."""


def whiten(
    errors: ReadingErrors,
    used: Float[Array, "frames samples"],
    apart: Float[Array, "frames samples"],
) -> Float[Array, "frames samples"]:
    """L^-1 times differences, C = L L' the covariance of the errors of one run [1].

    Each difference less what those before it foretell, over the standard deviation of that.

    Arguments:

    - `used`: 1 where there is a reading, 0 elsewhere [1]; there the result is zero.
    - `apart`: differences of simulation and readings [K].

    Source: Durbin and Koopman, Time Series Analysis by State Space Methods (2012), section 4.3.
    """
    white = _whiten_alone(errors, used, apart)
    if errors.common is None:
        return white
    return without_common_errors(errors.common, used, partial(_whiten_alone, errors, used), white)


def _whiten_alone(
    errors: ReadingErrors,
    used: Float[Array, "frames samples"],
    apart: Float[Array, "frames samples"],
) -> Float[Array, "frames samples"]:
    """The same by what samples do not have in common."""

    def rule(value: Array, expected: Array, deviation: Array) -> tuple[Array, Array]:
        return value - expected, (value - expected) / deviation

    return _along(errors, used, apart, rule) * used


@eqx.filter_jit
def in_common(
    errors: ReadingErrors,
    used: Float[Array, "frames samples"],
    frame: Float[Array, ""],
    lasting: Float[Array, ""],
) -> ReadingErrors:
    """Errors of samples that have nothing in common, and beside them what they have.

    `frame`: deviation of what all samples of a frame share, each frame by itself [K]; `lasting`: of
    what all readings share [K].
    """
    alone = partial(_whiten_alone, errors, used)
    return replace(errors, common=common_errors(lasting, frame, used, alone))


def colour(
    errors: ReadingErrors,
    used: Float[Array, "frames samples"],
    white: Float[Array, "frames samples"],
) -> Float[Array, "frames samples"]:
    """L times independent values [1] of variance one: differences [K], the inverse of `whiten`.

    Where there is no reading (`used` is 0 [1]) it is what the others foretell.
    """

    def rule(value: Array, expected: Array, deviation: Array) -> tuple[Array, Array]:
        return value * deviation, expected + value * deviation

    white = white * used
    if errors.common is not None:
        alone = partial(_whiten_alone, errors, used)
        white = with_common_errors(errors.common, used, alone, white)
    return _along(errors, used, white, rule)


def _along(
    errors: ReadingErrors,
    used: Float[Array, "frames samples"],
    values: Float[Array, "frames samples"],
    rule: Rule,
) -> Float[Array, "frames samples"]:
    """A Kalman filter with two states a sample: what fades, and what stays [K]."""

    def step(state: tuple[Array, ...], frame: tuple[Array, ...]) -> tuple[tuple[Array, ...], Array]:
        fades, stays, of_fading, of_both, of_staying = state
        kept, own, has, value = frame
        fades, of_both = kept * fades, kept * of_both
        of_fading = errors.fading + kept**2 * (of_fading - errors.fading)
        with_fading, with_staying = of_fading + of_both, of_both + of_staying
        total = with_fading + with_staying + own
        surprise, wanted = rule(value, fades + stays, jnp.sqrt(total))
        first, second = has * with_fading / total, has * with_staying / total
        after = (
            fades + first * surprise,
            stays + second * surprise,
            of_fading - first * with_fading,
            of_both - first * with_staying,
            of_staying - second * with_staying,
        )
        return after, wanted

    zero = jnp.zeros_like(errors.staying)
    begun = (zero, zero, zero + errors.fading, zero, errors.staying)
    return jax.lax.scan(step, begun, (errors.kept, errors.own, used, values))[1]

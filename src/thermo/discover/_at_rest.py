"""What a body at rest reads before its runs, against what the quiet frames read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.inverse import Addition, Case, read_at_rest

KNOWN: Final = 0.3
"""Standard deviation of what all samples of a run read wrongly before it, and do not before others
[K]: the temperature at which a body starts is known no better."""


def rest_residual(cases: Sequence[Case], additions: tuple[Addition, ...]) -> Float[Array, " runs"]:
    """What quiet frames read otherwise than the additions to the readings say, by run [1].

    A sample's constant error is taken off by its quiet frames, and with it all that a camera reads
    wrongly of a body at rest. How that differs from run to run tells of the camera: one of another
    scale is as much more wrong as a run begins warmer. What it has in common over runs does not,
    cameras are off by some kelvins; it is left out, and so are runs without quiet frames, or whose
    start was read off them.

    Source: Vollmer and Moellmann, Infrared Thermal Imaging (2018), section 3.2, a known hot start.
    """

    def one(case: Case) -> tuple[Array, Array]:
        held = case.pinned
        wrong = read_at_rest(case.under, len(held), additions)
        known = jnp.isfinite(case.resting)
        seen = jnp.where(known, case.resting, 0.0)
        return held @ wrong / jnp.maximum(held.sum(), 1.0) - seen, known

    pairs = [jax.vmap(one)(case) for case in cases]
    apart, known = (jnp.concatenate(each) for each in zip(*pairs, strict=True))
    common = jnp.sum(known * apart) / jnp.maximum(known.sum(), 1)
    return known * (apart - common) / KNOWN

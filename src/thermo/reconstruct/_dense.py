"""Layers of a small network."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray


@final
class Dense(eqx.Module):
    """Fully connected layers with a smooth ramp between them, for many places at a time.

    y = W_L r(... r(W_1 x + b_1) ...) + b_L, where r is softplus(beta x) / beta, beta = 100: smooth,
    so that a gradient by place has a gradient by weight, and straight but for a kink at zero.

    - `weights`, `biases`: of each layer [1].

    Source: Gropp et al., ICML 2020, section 5 (the ramp).
    """

    weights: tuple[Float[Array, "_ _"], ...]
    biases: tuple[Float[Array, " _"], ...]

    def __init__(self, widths: Sequence[int], *, silent: bool, key: PRNGKeyArray) -> None:
        """Random layers of `widths` [1]; a `silent` one gives zero until it has learned."""
        pairs = list(zip(widths[:-1], widths[1:], strict=True))
        keys = jax.random.split(key, len(pairs))
        drawn = [
            jax.random.normal(one, pair, jnp.float32) * sqrt(2.0 / pair[0])
            for one, pair in zip(keys, pairs, strict=True)
        ]
        if silent:
            drawn[-1] = jnp.zeros_like(drawn[-1])
        self.weights = tuple(drawn)
        self.biases = tuple(jnp.zeros(pair[1], jnp.float32) for pair in pairs)

    def __call__(self, values: Float[Array, "points inputs"]) -> Float[Array, "points outputs"]:
        """The layers' answer [1] to each row of `values` [1]."""
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            values = jax.nn.softplus(100.0 * (values @ weight + bias)) / 100.0
        return values @ self.weights[-1] + self.biases[-1]

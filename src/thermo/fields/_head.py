"""From unconstrained numbers to physical values within bounds."""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


class AbstractHead(eqx.Module):
    """A smooth, increasing map from all numbers [1] onto the open interval of the bounds."""

    @abstractmethod
    def value(self, raw: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Physical value, in the quantity's unit, of unconstrained numbers [1]."""

    @abstractmethod
    def raw(self, value: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Unconstrained numbers [1] of a physical value in the quantity's unit."""


def _logit(share: Float[Array, "*any"]) -> Float[Array, "*any"]:
    share = jnp.clip(share, 1e-9, 1 - 1e-9)
    return jnp.log(share) - jnp.log1p(-share)


@final
class LogHead(AbstractHead):
    """phi = lower (upper / lower)^s(u): equal steps in u are equal ratios of phi.

    s is the sigmoid with its slope set so that d log(phi) / du is 1 midway between the bounds.

    - `lower`, `upper`: bounds, positive, in the quantity's unit.

    Source: paper, appendix B.5 (checklist C3), with a logarithmic scale.
    """

    lower: float
    upper: float

    def _range(self) -> Float[Array, ""]:
        return jnp.log(self.upper / self.lower)

    def value(self, raw: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Physical value, in the quantity's unit, of unconstrained numbers [1]."""
        span = self._range()
        return self.lower * jnp.exp(span * jax.nn.sigmoid(4 * raw / span))

    def raw(self, value: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Unconstrained numbers [1] of a physical value in the quantity's unit."""
        span = self._range()
        return _logit(jnp.log(value / self.lower) / span) * span / 4


@final
class LinearHead(AbstractHead):
    """phi = lower + (upper - lower) s(u), the paper's head.

    - `lower`, `upper`: bounds in the quantity's unit.

    Source: paper, appendix B.5 (checklist C3).
    """

    lower: float
    upper: float

    def value(self, raw: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Physical value, in the quantity's unit, of unconstrained numbers [1]."""
        return self.lower + (self.upper - self.lower) * jax.nn.sigmoid(raw)

    def raw(self, value: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Unconstrained numbers [1] of a physical value in the quantity's unit."""
        return _logit((value - self.lower) / (self.upper - self.lower))

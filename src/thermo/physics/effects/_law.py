"""How a property changes with temperature."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


@final
class PolynomialLaw(eqx.Module):
    """Factor f(T) = sum_i a_i ((T - T_ref))^i on a property.

    - `coefficients`: a_i, (terms,) [1/K^i].
    - `reference`: T_ref [K].
    """

    coefficients: Float[Array, " terms"]
    reference: float

    def factor(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """f [1] at temperatures [K]."""
        return jnp.polyval(self.coefficients[::-1], temperature - self.reference)

    def integral(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Integral of f from T_ref [K]: the temperature rise that stores as much heat."""
        powers = jnp.arange(1, len(self.coefficients) + 1)
        raised = jnp.concatenate([jnp.zeros(1), self.coefficients / powers])
        return jnp.polyval(raised[::-1], temperature - self.reference)

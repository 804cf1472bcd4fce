"""How a property changes with temperature."""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import equinox as eqx
import jax.numpy as jnp
from jax.scipy.special import ndtr
from jax.scipy.stats import norm
from jaxtyping import Array, Float, Int


class AbstractLaw(eqx.Module):
    """Factor f(T) [1] on a property."""

    @abstractmethod
    def factor(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """f [1] at temperatures [K]."""

    @abstractmethod
    def integral(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Integral of f [K], from anywhere: differences are rises that store as much heat."""


@final
class PolynomialLaw(AbstractLaw):
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


@final
class TabulatedLaw(AbstractLaw):
    """Factor that runs linearly between given temperatures and is constant outside them.

    - `temperature`: (points,) two or more, increasing [K]; `value`: (points,) [1].
    """

    temperature: Float[Array, " points"]
    value: Float[Array, " points"]

    def factor(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """f [1] at temperatures [K]."""
        begin, above, slope = self._segment(self._within(temperature))
        return self.value[begin] + slope * above

    def integral(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Integral of f from the first temperature [K]."""
        rises = jnp.diff(self.temperature) * (self.value[1:] + self.value[:-1]) / 2
        until = jnp.concatenate([jnp.zeros(1), jnp.cumsum(rises)])
        within = self._within(temperature)
        begin, above, slope = self._segment(within)
        inside = until[begin] + (self.value[begin] + slope * above / 2) * above
        return inside + self.factor(within) * (temperature - within)

    def _within(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        return jnp.clip(temperature, self.temperature[0], self.temperature[-1])

    def _segment(
        self, within: Float[Array, "*any"]
    ) -> tuple[Int[Array, "*any"], Float[Array, "*any"], Float[Array, "*any"]]:
        """Where a segment begins, how far above that a temperature lies [K], its slope [1/K]."""
        # All points are compared at once, as a `History` does.
        after = jnp.searchsorted(self.temperature, within, side="right", method="compare_all")
        begin = jnp.clip(after, 1, self.temperature.size - 1) - 1
        slopes = jnp.diff(self.value) / jnp.diff(self.temperature)
        return begin, within - self.temperature[begin], slopes[begin]


@final
class SumLaw(AbstractLaw):
    """Factor f(T) = sum_i f_i(T).

    - `laws`: f_i [1].
    """

    laws: tuple[AbstractLaw, ...]

    def factor(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """f [1] at temperatures [K]."""
        return sum((law.factor(temperature) for law in self.laws), jnp.zeros_like(temperature))

    def integral(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Integral of f [K], from anywhere."""
        return sum((law.integral(temperature) for law in self.laws), jnp.zeros_like(temperature))


@final
class TransitionLaw(AbstractLaw):
    """Factor f(T) = base(T) + sum_i r_i n((T - m_i) / w_i) / w_i, n the bell of area one.

    Apparent heat capacity: what melts or changes its phase takes up latent heat over a range.

    - `rise`: r_i, latent heat over heat capacity, (transitions,) [K].
    - `middle`: m_i, `width`: w_i, the deviation of the bell, (transitions,) [K].
    - `base`: the factor without transitions; None where that is one.

    Source: Voller and Swaminathan, Numer. Heat Transfer B 19 (1991) 175, the enthalpy method.
    """

    rise: Float[Array, " transitions"]
    middle: Float[Array, " transitions"]
    width: Float[Array, " transitions"]
    base: AbstractLaw | None = None

    def factor(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """f [1] at temperatures [K]."""
        plain = jnp.ones_like(temperature) if self.base is None else self.base.factor(temperature)
        away = (temperature[..., None] - self.middle) / self.width
        return plain + norm.pdf(away) @ (self.rise / self.width)

    def integral(self, temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Integral of f from far below all transitions [K], but for a constant."""
        plain = temperature if self.base is None else self.base.integral(temperature)
        away = (temperature[..., None] - self.middle) / self.width
        return plain + ndtr(away) @ self.rise

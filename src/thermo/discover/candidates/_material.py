"""Effects inside the body: properties that vary with temperature, direction or place."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, final

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.discover._candidate import (
    FINE,
    AbstractHeatCandidate,
    Card,
    Inclusion,
    Place,
    Transition,
    unit,
)
from thermo.inverse import Conditions
from thermo.observe import REFERENCE
from thermo.physics import Model, volume_rule
from thermo.physics.effects import AbstractLaw, PolynomialLaw, SumLaw, TransitionLaw

# A void lets this share of the heat through [1], so that temperatures inside stay defined.
_LEAST = 1e-4


def _sloped(stated: AbstractLaw | None, slope: Float[Array, ""]) -> AbstractLaw:
    if stated is None:
        return PolynomialLaw(jnp.stack([jnp.ones(()), slope]), REFERENCE)
    return SumLaw((stated, PolynomialLaw(jnp.stack([jnp.zeros(()), slope]), REFERENCE)))


@final
class TemperatureDependentConductivity(AbstractHeatCandidate):
    """k(T) = k (f(T) + strength (T - 293.15 K)), f as stated, else 1."""

    card: ClassVar[Card] = Card(
        "temperature_dependent_conductivity", "1/K", 5e-3, -0.05, 0.05,
        excited_by="steep gradients at temperatures over a wide range",
        hides_behind="conductivity that depends on the direction, cells that are too large",
        split_by="the same heating at another power",
        law=True,
        means="share by which the conductivity grows for each kelvin above 293.15 K",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a conductivity that changes with temperature."""
        del under
        return replace(model, conductivity_law=_sloped(model.conductivity_law, self.strength[0]))


@final
class TemperatureDependentHeatCapacity(AbstractHeatCandidate):
    """c(T) = c (f(T) + strength (T - 293.15 K)), f as stated, else 1."""

    card: ClassVar[Card] = Card(
        "temperature_dependent_heat_capacity", "1/K", 5e-3, -0.05, 0.05,
        excited_by="temperatures over a wide range",
        hides_behind="radiation, the camera's scale",
        split_by="the same heating at another power",
        law=True,
        means="share by which the capacity grows for each kelvin above 293.15 K",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a capacity that changes with temperature."""
        del under
        return replace(model, capacity_law=_sloped(model.capacity_law, self.strength[0]))


@final
class LatentHeat(AbstractHeatCandidate):
    """c(T) = c f(T) + strength / width n((T - middle) / width), n the bell of area one.

    f as stated, else 1.

    - `density`: of the body [kg/m3].

    Source: Voller and Swaminathan, Numer. Heat Transfer B 19 (1991) 175.
    """

    card: ClassVar[Card] = Card(
        "latent_heat", "J/kg", 2e4, 0.0, 1e6,
        excited_by="temperatures that pass the transition slowly",
        hides_behind="a capacity that changes with temperature, radiation, a slow sensor",
        split_by="a run that stays below the transition and one that stays above it",
        law=True,
        means="heat taken up over a range of temperature",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Transition
    density: Float[Array, ""]

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a phase that changes."""
        del under
        rise = self.strength * self.density / jnp.mean(model.capacity)
        law = TransitionLaw(rise, self.place.centre, self.place.size, model.capacity_law)
        return replace(model, capacity_law=law)


@final
class AnisotropicConductivity(AbstractHeatCandidate):
    """Conductivity along x, y or z that is higher by a share, k_x = k (1 + strength)."""

    card: ClassVar[Card] = Card(
        "anisotropic_conductivity", "1", 0.5, -0.95, 20.0,
        excited_by="heat that flows along several axes",
        hides_behind="conductivity that changes with temperature, cells that are too large",
        split_by="another face heated",
        means="share by which it conducts better along one axis",
        parts=("along x", "along y", "along z"),
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a tensor of conductivity."""
        del under
        whole = model.conductivity
        if whole.ndim == 3:
            # It stays symmetric, and positive definite.
            root = jnp.sqrt(1 + self.strength)
            return replace(model, conductivity=whole * root[:, None] * root)
        return replace(model, conductivity=whole[:, None, None] * jnp.diag(1 + self.strength))


@final
class Void(AbstractHeatCandidate):
    """A body within that conducts poorly, k (1 - strength inside), inside as of an `Inclusion`.

    Its sizes along x, y and z are free, so that it can be flat as a crack or a delamination, and so
    are its form, from an ellipsoid to a box, and how sharp its edge is. A cell that its edge cuts
    conducts as layers do: by the mean of k along the edge and by the harmonic mean across it. So
    what is thinner than a cell holds heat back as well.

    Source: Milton, The Theory of Composites (2002), chapter 9, laminates.
    """

    card: ClassVar[Card] = Card(
        "void", "1", 0.9, 0.0, 0.999,
        excited_by="heat that flows through the place",
        hides_behind="a conductivity that varies",
        split_by="heat from the other side",
        means="share of the conductivity that is lost inside it",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Inclusion

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with voids in it."""
        del under
        rule = volume_rule(model.space, FINE)
        weight = rule.weight / rule.weight.sum(0)
        inside = self.place.shapes(rule.at)
        factor = jnp.maximum(1 - jnp.einsum("p,pqc->qc", self.strength, inside), _LEAST)
        along, across = jnp.sum(weight * factor, 0), 1 / jnp.sum(weight / factor, 0)
        share = jnp.einsum("pqc,qc->pc", inside, weight)
        normals = self.place.normals(jnp.einsum("qcx,qc->cx", rule.at, weight))
        # Of cells that several edges cut the one that counts most is followed most.
        weighs = jax.lax.stop_gradient(self.strength[:, None] * share * (1 - share))
        normal = unit(jnp.einsum("pc,pcx->cx", weighs, normals))
        whole = model.conductivity
        tensor = whole if whole.ndim == 3 else whole[:, None, None] * jnp.eye(3)
        flow = jnp.einsum("cxy,cy->cx", tensor, normal)
        level = jnp.einsum("cx,cx->c", flow, normal)
        layered = ((across - along) / level)[:, None, None] * flow[:, :, None] * flow[:, None, :]
        return replace(model, conductivity=along[:, None, None] * tensor + layered)

"""An effect that may be missing in a model: what it is, how strong, where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.inverse import AbstractHeatAddition, AbstractReadingAddition
from thermo.physics import Discretisation, volume_rule

FINE: Final = 5
"""Degree of the rule [1] for what varies within a cell: light that is soon gone, edges of voids."""

Shapes = Float[Array, "places points cells"]
"""Share of each place's full strength [1]."""


@final
@dataclass(frozen=True)
class Card:
    """What is known of a kind of effect before any data.

    - `name`; `unit` of its strength; `typical`: a strength that would be large, in that unit.
    - `low`, `high`: what its strength can be, in that unit.
    - `joint`: its strengths belong together, as those of one history; else each is a place, an
      axis or a kind by itself, and one of them is looked for.
    - `law`: whether it makes properties change with temperature: a step takes two iterations then.
    - `fault`: whether it is a fault of the record that may stand in for an effect: it is looked for
      and told of, and never named.
    - `excited_by`, `hides_behind`, `split_by`: in words.
    """

    name: str
    unit: str
    typical: float
    low: float
    high: float
    excited_by: str
    hides_behind: str
    split_by: str
    joint: bool = False
    law: bool = False
    fault: bool = False


@final
class Place(eqx.Module):
    """Where effects are: exp(-r^2 / (2 size^2)) about a centre, one each.

    - `centre`: (places, 3) [m]; None where the candidate itself says where it begins.
    - `size`: (places,) [m]; a depth where there is no centre. Or (places, 3), along x, y and z.
    """

    centre: Float[Array, "places 3"] | None
    size: Float[Array, " places"] | Float[Array, "places 3"]

    def shapes(self, at: Float[Array, "*any 3"]) -> Float[Array, "places *any"]:
        """Share of each place's full strength [1] at points [m]."""
        return jnp.stack([jnp.exp(-jnp.sum(way**2, -1) / 2) for way in self._ways(at)])

    def boxes(self, at: Float[Array, "*any 3"]) -> Float[Array, "places *any"]:
        """The same with exp(-sum of (way / size)^8), a box with slightly rounded edges [1]."""
        return jnp.stack([jnp.exp(-jnp.sum(way**8, -1)) for way in self._ways(at)])

    def _ways(self, at: Float[Array, "*any 3"]) -> list[Float[Array, "*any 3"]]:
        """From each centre to points [m], over the place's size [1]."""
        assert self.centre is not None, "a depth has no shape of its own"
        return [(at - c) / s for c, s in zip(self.centre, self.size, strict=True)]


@final
class Transition(eqx.Module):
    """Where on the scale of temperature effects are: bells about a middle, one each.

    - `centre`: (places,) [K]; `size`: deviation of the bell, (places,) [K].
    """

    centre: Float[Array, " places"]
    size: Float[Array, " places"]


class AbstractHeatCandidate(AbstractHeatAddition):
    """A candidate that changes the heat equation.

    - `strength`: (parts,) in the card's unit, zero where the effect is absent.
    - `place`: of each part, in the body [m] or on the scale of temperature [K]; or None.
    """

    card: eqx.AbstractClassVar[Card]
    strength: eqx.AbstractVar[Float[Array, " parts"]]
    place: eqx.AbstractVar[Place | Transition | None]


class AbstractReadingCandidate(AbstractReadingAddition):
    """A candidate that changes what is read; fields as in `AbstractHeatCandidate`."""

    card: eqx.AbstractClassVar[Card]
    strength: eqx.AbstractVar[Float[Array, " parts"]]
    place: eqx.AbstractVar[Place | Transition | None]


Candidate = AbstractHeatCandidate | AbstractReadingCandidate
"""An effect that may be missing."""


def on_faces(space: Discretisation, place: Place) -> Float[Array, "places faces"]:
    """Mean of each place's shape over each face [1]."""
    share = face_shares(space)
    return jnp.einsum("pfq,fq->pf", place.shapes(jnp.asarray(space.face_point)), share)


def cell_means(
    space: Discretisation, shapes: Callable[[Float[Array, "points cells 3"]], Shapes]
) -> Float[Array, "places cells"]:
    """Mean of each place's shape over each cell [1], which may vary within a cell."""
    rule = volume_rule(space, FINE)
    whole = jnp.einsum("pqc,qc->pc", shapes(rule.at), rule.weight)
    return whole / rule.weight.sum(0)


def face_shares(space: Discretisation) -> Float[Array, "faces points"]:
    """Weights [1] of the points of each face in a mean over it."""
    weight = jnp.asarray(space.face_weight)
    return weight / weight.sum(1, keepdims=True)

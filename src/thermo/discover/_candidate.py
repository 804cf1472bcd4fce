"""An effect that may be missing in a model: what it is, how strong, where."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.inverse import AbstractHeatAddition, AbstractReadingAddition

FINE: Final = 5
"""Degree of the rule [1] for what varies within a cell: light that is soon gone, edges of voids."""

# Squares of ways over sizes [1] below which one is in the middle and above which one is far away.
_MIDDLE: Final = 1e-12
_FAR: Final = 100.0

SQUARENESS: Final = (4.0, 2.0, 12.0)
"""Of an `Inclusion` where it is looked for at first, the least and the largest [1]."""

SHARPNESS: Final = (8.0, 4.0, 24.0)
"""The same of its edge [1]; a sharper one falls between the points of the rule over a cell."""

_DIRECTIONS: Final = 4000
"""In which the edge of an inclusion is looked at [1]."""


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
    - `smallest`: of a place over its first size [1].
    - `alike`: in words, what no candidate stands for and reads as a positive strength does.
    - `means`: in words, what the strength is; none where name and unit say so.
    - `edged`: whether its places may be of the form of an `Inclusion` as well as bells.
    - `total`: whether a strength is that of all its place together, not that of each point of it.
    - `parts`: in words, what each strength by itself is, as "along x"; none where these are places.
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
    smallest: float = 0.25
    alike: str = ""
    means: str = ""
    edged: bool = False
    total: bool = False
    parts: tuple[str, ...] = ()


@final
class Place(eqx.Module):
    """Where effects are: exp(-r^2 / (2 size^2)) about a centre, one each.

    - `centre`: (places, 3) [m]; None where the candidate itself says where it begins.
    - `size`: (places,) [m]; a depth where there is no centre.
    """

    centre: Float[Array, "places 3"] | None
    size: Float[Array, " places"]

    def shapes(self, at: Float[Array, "*any 3"]) -> Float[Array, "places *any"]:
        """Share of each place's full strength [1] at points [m]."""
        assert self.centre is not None, "a depth has no shape of its own"
        # One program for all places: written down for each, most of a search's compiling is this.
        return jax.vmap(lambda c, s: _bell((at - c) / s))(self.centre, self.size)


@final
class Inclusion(eqx.Module):
    """Bodies within the body: exp(-r^sharpness), r^squareness = sum of |way / size|^squareness.

    - `centre`, `size`: (places, 3), along x, y and z [m].
    - `squareness`: (places,) [1], 2 for an ellipsoid, more for a box; `sharpness`: (places,) of the
      edge [1].

    Source: Barr, IEEE Computer Graphics and Applications 1 (1981) 11, the superellipsoid.
    """

    centre: Float[Array, "places 3"]
    size: Float[Array, "places 3"]
    squareness: Float[Array, " places"]
    sharpness: Float[Array, " places"]

    def shapes(self, at: Float[Array, "*any 3"]) -> Float[Array, "places *any"]:
        """Share of each place's full strength [1] at points [m]."""
        return jax.vmap(lambda c, s, square, sharp: _inside((at - c) / s, square, sharp))(
            self.centre, self.size, self.squareness, self.sharpness
        )

    def normals(self, at: Float[Array, "*any 3"]) -> Float[Array, "places *any 3"]:
        """Normals [1] of the surfaces r = constant through points [m]; along z in the middle."""
        return jax.vmap(lambda c, s, square: unit(_outward((at - c) / s, square) / s))(
            self.centre, self.size, self.squareness
        )

    def only(self, part: int) -> Inclusion:
        """One of the places [m]."""
        return jax.tree.map(lambda each: each[part : part + 1], self)

    def edge(self, part: int) -> Float[np.ndarray, "points 3"]:
        """Points [m] at r = 1 about one of the places, spread over all directions."""
        turns = np.arange(_DIRECTIONS) + 0.5
        height = 1 - 2 * turns / _DIRECTIONS
        around = np.pi * (1 + np.sqrt(5)) * turns
        flat = np.sqrt(1 - height**2)
        ways = np.stack([flat * np.cos(around), flat * np.sin(around), height], axis=1)
        square = float(self.squareness[part])
        radius = np.sum(np.abs(ways) ** square, axis=1, keepdims=True) ** (1 / square)
        return np.asarray(self.centre[part]) + ways / radius * np.asarray(self.size[part])


def _bell(way: Float[Array, "*any 3"]) -> Float[Array, "*any"]:
    return jnp.exp(-jnp.sum(way**2, -1) / 2)


def _inside(
    way: Float[Array, "*any 3"], squareness: Float[Array, ""], sharpness: Float[Array, ""]
) -> Float[Array, "*any"]:
    # Within these bounds powers, and their slopes by the exponents, are finite.
    squares = jnp.clip(way**2, _MIDDLE, _FAR)
    radius = jnp.sum(squares ** (squareness / 2), -1) ** (1 / squareness)
    return jnp.exp(-(radius**sharpness))


def unit(vector: Float[Array, "*any 3"]) -> Float[Array, "*any 3"]:
    """Vectors of length one [1]; where there is no direction, one along z that has no slope."""
    # Over the largest part first: high powers of small numbers have squares that vanish.
    largest = jax.lax.stop_gradient(jnp.abs(vector).max(-1, keepdims=True))
    known = largest > 0
    scaled = jnp.where(known, vector / jnp.where(known, largest, 1.0), jnp.array([0.0, 0.0, 1.0]))
    return scaled / jnp.linalg.norm(scaled, axis=-1, keepdims=True)


def _outward(way: Float[Array, "*any 3"], squareness: Float[Array, ""]) -> Float[Array, "*any 3"]:
    """Slope of r^squareness over the squareness."""
    squares = jnp.clip(way**2, _MIDDLE, _FAR)
    return jnp.sign(way) * squares ** ((squareness - 1) / 2)


@final
class Transition(eqx.Module):
    """Where on the scale of temperature effects are: bells about a middle, one each.

    - `centre`: (places,) [K]; `size`: deviation of the bell, (places,) [K].
    """

    centre: Float[Array, " places"]
    size: Float[Array, " places"]


Where = Place | Inclusion | Transition
"""Of each part of a candidate, where it is."""


class AbstractHeatCandidate(AbstractHeatAddition):
    """A candidate that changes the heat equation.

    - `strength`: (parts,) in the card's unit, zero where the effect is absent.
    - `place`: of each part, in the body [m] or on the scale of temperature [K]; or None.
    """

    card: eqx.AbstractClassVar[Card]
    strength: eqx.AbstractVar[Float[Array, " parts"]]
    place: eqx.AbstractVar[Where | None]


class AbstractReadingCandidate(AbstractReadingAddition):
    """A candidate that changes what is read; fields as in `AbstractHeatCandidate`."""

    card: eqx.AbstractClassVar[Card]
    strength: eqx.AbstractVar[Float[Array, " parts"]]
    place: eqx.AbstractVar[Where | None]


Candidate = AbstractHeatCandidate | AbstractReadingCandidate
"""An effect that may be missing."""


def with_edge(one: Candidate) -> Candidate:
    """The candidate with even places that have an edge, for bells of the same second moments [m].

    As it is where its places are no bells, or may be nothing else. A disc has the moments of a
    bell half as wide.
    """
    bells = one.place
    if not one.card.edged or not isinstance(bells, Place) or bells.centre is None:
        return one
    ones = jnp.ones_like(bells.size)
    size = jnp.broadcast_to(2.0 * bells.size[:, None], bells.centre.shape)
    even = Inclusion(bells.centre, size, SQUARENESS[0] * ones, SHARPNESS[0] * ones)
    return replace(one, place=even)

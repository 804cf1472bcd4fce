"""The way of a lamp's light through the body."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.mesh import Surface, caster_of, first_hits
from thermo.observe import Heater
from thermo.physics import Discretisation

GRAZED: Final = 0.1
"""Cosine [1] between light and a face's inward normal below which its plane tells no depth."""


@final
class LightPath(eqx.Module):
    """Where the light of a lamp enters on its straight way to each cell.

    A lamp throws no shadow, as on the surface: what lies behind a gap is lit anew.

    - `entry`: (cells, 3) [m], on the way to the cell's centre; `lit`: (cells,), 0 where there is no
      lamp [1].
    - `inward`: (cells, 3), what a way of length one takes below the surface where the light enters,
      along the light [1].
    - `centre`: of the lamp's axis, (3,) [m]; `direction` of the light, (3,) [1]; `radius` [m].
    """

    entry: Float[Array, "cells 3"]
    lit: Float[Array, " cells"]
    inward: Float[Array, "cells 3"]
    centre: Float[Array, " 3"]
    direction: Float[Array, " 3"]
    radius: Float[Array, ""]

    def below(self, at: Float[Array, "points cells 3"]) -> Float[Array, "points cells"]:
        """How far the light goes through the body up to points of the cells [m]."""
        return jnp.maximum(jnp.sum((at - self.entry) * self.inward, -1), 0.0)

    def light(self, at: Float[Array, "points cells 3"]) -> Float[Array, "points cells"]:
        """Irradiance across the beam at points of the cells [m], over that on its axis [1]."""
        off = at - self.centre
        across = off - (off @ self.direction)[..., None] * self.direction
        return self.lit * jnp.exp(-jnp.sum(across**2, -1) / (2 * self.radius**2))


def dark(cells: int) -> LightPath:
    """The way of no light to so many cells [1]."""
    nowhere, none = jnp.zeros((cells, 3)), jnp.zeros(cells)
    return LightPath(nowhere, none, nowhere, jnp.zeros(3), jnp.zeros(3), jnp.ones(()))


def light_path(heater: Heater, space: Discretisation) -> LightPath:
    """The way of the light of a lamp to the cells of a body [m]."""
    mesh = space.mesh
    direction = np.asarray(heater.direction, float) / np.linalg.norm(heater.direction)
    middle = mesh.nodes[mesh.cells[:, :4]].mean(1)
    back = np.broadcast_to(-direction, middle.shape)
    skin = caster_of(Surface(mesh.nodes, mesh.faces[:, :3].astype(np.int64)))
    met = first_hits(skin, middle, back)
    lit = met.triangle >= 0
    far = np.where(lit, met.distance, 0.0)[:, None]
    normal = -mesh.normals[met.triangle]
    steep = normal @ direction
    # The plane of a face that light only grazes is far from what else of the cell is lit through.
    sloped = np.where(steep > GRAZED, steep, 1.0)[:, None]
    inward = np.where((steep > GRAZED)[:, None], normal / sloped, direction)
    return LightPath(
        jnp.asarray(middle - far * direction),
        jnp.asarray(lit.astype(float)),
        jnp.asarray(inward),
        jnp.asarray(heater.centre, float),
        jnp.asarray(direction),
        jnp.asarray(float(heater.radius)),
    )

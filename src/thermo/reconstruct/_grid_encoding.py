"""Features of a place, interpolated on grids from coarse to fine."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray


@final
class GridEncoding(eqx.Module):
    """Trilinear features on cubic grids over [-1, 1]^3.

    Of each level l with n_l cells an edge, g_l(x) = sum over the eight corners of the cell about x
    of the corner's features times the trilinear weight. Dense grids: at the sizes in use a table
    fits the memory, and no two corners share an entry.

    - `tables`: features [1] at the corners of each level, (n_l + 1)^3 rows.
    - `cells`: n_l.

    Source: Mueller et al., ACM Transactions on Graphics 41 (2022) 102, its section 3
    without hashing.
    """

    tables: tuple[Float[Array, "_ features"], ...]
    cells: tuple[int, ...] = eqx.field(static=True)

    def __init__(self, cells: Sequence[int], features: int, *, key: PRNGKeyArray) -> None:
        self.cells = tuple(cells)
        keys = jax.random.split(key, len(self.cells))
        self.tables = tuple(
            jax.random.uniform(
                one, ((count + 1) ** 3, features), jnp.float32, minval=-1e-4, maxval=1e-4
            )
            for one, count in zip(keys, self.cells, strict=True)
        )

    def __call__(
        self, places: Float[Array, "points 3"], open_levels: Float[Array, ""]
    ) -> Float[Array, "points encoded"]:
        """Features [1] at places [1]; of levels above `open_levels` [1] nothing is let through.

        A level that opens comes in with its fraction, so that fine detail follows coarse shape.
        """
        parts = [
            _interpolated(table, count, places) * jnp.clip(open_levels - level, 0.0, 1.0)
            for level, (table, count) in enumerate(zip(self.tables, self.cells, strict=True))
        ]
        return jnp.concatenate(parts, axis=1)


def _interpolated(
    table: Float[Array, "corners features"], cells: int, places: Float[Array, "points 3"]
) -> Float[Array, "points features"]:
    scaled = (jnp.clip(places, -1.0, 1.0) + 1.0) * (0.5 * cells)
    # The last corner belongs to the last cell, not to one beyond the grid.
    first = jnp.clip(jnp.floor(scaled), 0, cells - 1).astype(jnp.int32)
    share = scaled - first
    total = 0.0
    for corner in product((0, 1), repeat=3):
        x, y, z = (first[:, axis] + corner[axis] for axis in range(3))
        weights = [share[:, a] if corner[a] else 1.0 - share[:, a] for a in range(3)]
        row = (x * (cells + 1) + y) * (cells + 1) + z
        total = total + table[row] * (weights[0] * weights[1] * weights[2])[:, None]
    return jnp.asarray(total)

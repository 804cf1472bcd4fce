"""A grid of small cubes, and what lines of sight cross of it."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int


@final
class Voxels(eqx.Module):
    """Cubes that fill a box, numbered with x slowest and z fastest.

    - `low`: the box's lowest corner, (3,) [m]. `edge`: of a voxel [m]. `cells`: voxels along x, y
      and z [1].
    """

    low: Float[np.ndarray, "3"]
    edge: float
    cells: tuple[int, int, int] = eqx.field(static=True)

    def middles(self) -> Float[np.ndarray, "voxels 3"]:
        """Middle of each voxel [m]."""
        number = np.indices(self.cells).reshape(3, -1).T
        return self.low + self.edge * (number + 0.5)


def voxels_in(low: Float[np.ndarray, "3"], high: Float[np.ndarray, "3"], longest: int) -> Voxels:
    """Voxels that fill the box from `low` to `high` [m], `longest` of them along its longest edge.

    They reach less than a voxel beyond `high` along the others.
    """
    edge = float((high - low).max()) / longest
    # Rounding must not add a layer.
    cells = np.maximum(np.ceil((high - low) / edge - 1e-9), 1).astype(int)
    return Voxels(low, edge, (int(cells[0]), int(cells[1]), int(cells[2])))


def crossed(
    voxels: Voxels, origin: Float[np.ndarray, "3"], lines: Float[np.ndarray, "lines 3"]
) -> Int[np.ndarray, "lines steps"]:
    """Voxels that lines of sight cross, near ones first, with -1 where they are outside.

    Lines are looked at in steps of half a voxel: of voxels that a line clips at a corner it may
    miss some.

    Arguments: `origin` of all lines [m]; `lines`, of length one [1], NaN where nothing is seen.
    """
    size = voxels.edge * np.array(voxels.cells)
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (voxels.low - origin) / lines, (voxels.low + size - origin) / lines
        near = np.maximum(np.minimum(first, second).max(axis=1), 0.0)
        far = np.maximum(first, second).min(axis=1)
    meets = far > near
    length = np.where(meets, far - near, 0.0)
    steps = int(np.ceil(length.max(initial=0.0) / (0.5 * voxels.edge))) + 1
    along = np.where(meets, near, 0.0)[:, None] + 0.5 * voxels.edge * (np.arange(steps) + 0.5)
    places = origin + along[:, :, None] * np.where(meets[:, None], lines, 0.0)[:, None, :]
    number = np.floor((places - voxels.low) / voxels.edge).astype(np.int64)
    inside = meets[:, None] & ((number >= 0) & (number < voxels.cells)).all(axis=2)
    flat = (number[..., 0] * voxels.cells[1] + number[..., 1]) * voxels.cells[2] + number[..., 2]
    return np.where(inside, flat, -1)

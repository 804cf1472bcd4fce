"""Photographs whose mask and pose do not go with those of the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from jaxtyping import Bool

from thermo.imaging import pixel_centres, rays

from ._photograph import Photograph
from ._region import Region
from ._visual_hull import Carving, carve, cones_of
from ._voxels import Voxels, crossed, voxels_in

_VOXELS: Final = 64
"""Along the region's edge [1]."""
_LINES: Final = 2000
"""Pixels of a mask that are looked at, at the most [1]."""


def explained(photographs: Sequence[Photograph], region: Region) -> dict[int, float]:
    """Share of each mask behind which the other photographs leave room for an object [1].

    By number of the photograph, of those with a mask that shows anything. Where masks and poses
    are right the share is 1: the object itself is there. A photograph that stands wrong looks past
    the room that the others leave. It also denies room to the others, so that what the most
    photographs, all but a few, allow counts as room.

    Source: after Laurentini, IEEE Trans. Pattern Analysis and Machine Intelligence 16 (1994) 150.
    """
    cones = cones_of(photographs)
    grid = voxels_in(region.centre - region.half, region.centre + region.half, _VOXELS)
    carving = carve(cones, grid)
    spared = max(1, len(cones) // 8)
    found = {}
    for place, cone in enumerate(cones):
        room = _room(carving, place, spared)
        found[cone.number] = _met(photographs[cone.number], grid, room)
    return found


def _room(carving: Carving, left_out: int, spared: int) -> Bool[np.ndarray, " voxels"]:
    """Voxels that at most `spared` photographs deny, one of them left out."""
    others = carving.denials() - carving.denied[left_out]
    least = int(others.min())
    # What a third of the photographs deny everywhere is no room that the others agree on.
    return others <= (least + spared if 3 * least <= len(carving.denied) else -1)


def _met(photograph: Photograph, grid: Voxels, room: Bool[np.ndarray, " voxels"]) -> float:
    """Share of the object's pixels whose line of sight meets the room [1]."""
    assert photograph.mask is not None
    shown = np.flatnonzero(photograph.mask.ravel() > 0.5)
    picked = shown[np.linspace(0, len(shown) - 1, min(_LINES, len(shown))).astype(int)]
    camera = photograph.camera
    lines = rays(camera, pixel_centres(camera)[picked])
    voxels = crossed(grid, camera.place(), lines)
    meets = (room[voxels] & (voxels >= 0)).any(axis=1)
    return float(meets.mean())

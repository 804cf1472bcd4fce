"""The room that masks leave for the object: what no photograph denies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from thermo.imaging import Camera, project, rays

from ._photograph import Photograph
from ._voxels import Voxels

_SLACK: Final = 1.0
"""What a mask's edge may be off by [px]: its pixels are whole."""
_SEEN: Final = 0.25
"""Least share of the photographs that see most of the room which must see a place of it [1].

Where the cones of few cameras reach behind the others, nothing else denies them.
"""


@final
class Cone(eqx.Module):
    """A camera and the mask that it looks through.

    - `number`: of its photograph, from zero.
    - `beyond`: distance of each pixel from the nearest that shows the object, (rows, columns) [px].
    - `widest`: tangent of the angle between the camera's axis and its outermost line of sight [1].
    - `whole`: whether all of the object is in the picture, since the mask meets no edge of it.
    """

    camera: Camera
    number: int = eqx.field(static=True)
    beyond: Float[np.ndarray, "rows columns"]
    widest: float
    whole: bool = eqx.field(static=True)


@final
class Carving(eqx.Module):
    """What masks say of voxels.

    - `voxels`: the grid. `numbers`: of the photographs.
    - `seen`: photographs that have a voxel in the picture, (voxels,) [1].
    - `denied`: which of them show no object there, (photographs, voxels).
    """

    voxels: Voxels
    numbers: tuple[int, ...] = eqx.field(static=True)
    seen: Int[np.ndarray, " voxels"]
    denied: Bool[np.ndarray, "photographs voxels"]

    def denials(self) -> Int[np.ndarray, " voxels"]:
        """Photographs that deny each voxel [1]; more than there are where too few see it."""
        enough = self.seen >= max(2, np.ceil(_SEEN * self.seen.max(initial=0)))
        return np.where(enough, self.denied.sum(axis=0), len(self.denied) + 1)


def cones_of(photographs: Sequence[Photograph]) -> tuple[Cone, ...]:
    """The cones of all photographs that have a mask and show the object."""
    return tuple(
        Cone(
            one.camera, number, _beyond(one.mask > 0.5), _widest(one.camera), _whole(one.mask > 0.5)
        )
        for number, one in enumerate(photographs)
        if one.mask is not None and np.any(one.mask > 0.5)
    )


def carve(cones: Sequence[Cone], voxels: Voxels) -> Carving:
    """Ask each photograph about each voxel.

    A photograph denies a voxel that is in its picture and at which no pixel within the voxel's
    reach shows the object, and one out of its picture where that shows all of the object. What
    masks of the object leave therefore holds the object, and is up to a voxel larger than their
    visual hull.

    Source: Laurentini, IEEE Trans. Pattern Analysis and Machine Intelligence 16 (1994) 150.
    """
    middles = voxels.middles()
    seen = np.zeros(len(middles), np.int32)
    denied = np.zeros((len(cones), len(middles)), bool)
    for number, cone in enumerate(cones):
        inside, denied[number] = _looked(cone, middles, 0.5 * np.sqrt(3.0) * voxels.edge)
        seen += inside
    return Carving(voxels, tuple(one.number for one in cones), seen, denied)


def _looked(
    cone: Cone, middles: Float[np.ndarray, "voxels 3"], reach: float
) -> tuple[Bool[np.ndarray, " voxels"], Bool[np.ndarray, " voxels"]]:
    """Which voxels of half-diagonal `reach` [m] are in the picture, and which are denied."""
    camera = cone.camera
    pixels, depth = project(camera, middles)
    size = np.array([camera.width, camera.height])
    with np.errstate(invalid="ignore"):
        inside = ((pixels > -0.5) & (pixels < size - 0.5)).all(axis=1) & (depth > reach)
    if np.any(camera.distortion):
        # Far out a lens's polynomial folds back, and what is out of sight would be in the picture.
        seen = (middles - camera.place()) @ camera.pose[:3, :3].T
        inside &= np.hypot(seen[:, 0], seen[:, 1]) <= cone.widest * depth
    about = camera.focal.max() * reach / (depth[inside] - reach)
    column, row = np.rint(pixels[inside]).astype(np.int64).T
    denied = np.zeros(len(middles), bool)
    if cone.whole:
        # A large voxel whose middle is just out of the picture may hold a part that is in it.
        with np.errstate(invalid="ignore", divide="ignore"):
            beyond = np.maximum(-0.5 - pixels, pixels - size + 0.5).max(axis=1)
            far = beyond > camera.focal.max() * reach / (depth - reach) + _SLACK
        denied = ~inside & ((far & (depth > reach)) | (depth < -reach))
    denied[inside] = cone.beyond[row, column] > about + _SLACK
    return inside | denied, denied


def _whole(mask: Bool[np.ndarray, "rows columns"]) -> bool:
    return not (mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())


def _beyond(mask: Bool[np.ndarray, "rows columns"]) -> Float[np.ndarray, "rows columns"]:
    distance = np.asarray(ndimage.distance_transform_edt(np.logical_not(mask)))
    return distance.astype(np.float32)


def _widest(camera: Camera) -> float:
    columns, rows = np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float)
    edges = [np.stack([columns, np.full_like(columns, row)], axis=1) for row in (0, rows[-1])]
    edges += [np.stack([np.full_like(rows, one), rows], axis=1) for one in (0, columns[-1])]
    sight = rays(camera, np.concatenate(edges)) @ camera.pose[:3, :3].T
    return float(np.nanmax(np.hypot(sight[:, 0], sight[:, 1]) / sight[:, 2], initial=0.0))

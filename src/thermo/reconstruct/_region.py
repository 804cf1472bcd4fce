"""The cube that holds the object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.observe import real_array

from ._meeting import meeting, sight_of_object, sight_of_picture
from ._photograph import Photograph
from ._visual_hull import Carving, Cone, carve, cones_of
from ._voxels import voxels_in

MARGIN: Final = 0.1
"""How much larger the cube is than what has to be in it [1]."""
_COARSE: Final = 48
"""Voxels along the cube in which the object is searched for, and then along the object [1]."""
_GROWN: Final = 4
"""How often the cube is doubled where the object reaches its faces, at the most [1]."""


@final
class Region(eqx.Module):
    """A cube along the world's axes; in its own unit it is [-1, 1]^3.

    - `centre`: (3,) [m]. `half`: of its edge [m].
    - `room`: lowest and highest corner of what the object cannot reach out of, (2, 3) [m]; None
      where nobody knows.
    """

    centre: Float[np.ndarray, "3"]
    half: float
    room: Float[np.ndarray, "2 3"] | None = None


def to_unit(region: Region, points: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
    """Points of the world [m] in halves of the region's edge from its centre [1]."""
    return (points - region.centre) / region.half


def from_unit(
    region: Region, points: Float[np.ndarray, "points 3"]
) -> Float[np.ndarray, "points 3"]:
    """The inverse of `to_unit`: points of the region [1] in the world [m]."""
    return region.centre + region.half * points


def region_of(photographs: Sequence[Photograph], box: object = None) -> Region:
    """Where to look for the object.

    A stated box decides, and nothing beyond it is taken for the object. Without one, photographs
    with masks leave room for the object in no more than their visual hull, and the cube is that of
    the hull's box. Where masks leave no room, or there are none, the cube is a guess: about the
    place that the cameras look at, as large as most of them have it in their pictures. All cubes
    are larger by a tenth.

    Arguments:

    - `photographs`: of one object.
    - `box`: its lowest and highest corner, (2, 3) [m].

    Raises `InputError` for a box that is none, and where there is neither a box nor two cameras
    whose lines of sight meet.

    Source: Laurentini, IEEE Trans. Pattern Analysis and Machine Intelligence 16 (1994) 150.
    """
    if box is not None:
        return _about(_checked(box), told=True)
    cones = cones_of(photographs)
    if len(cones) > 1:
        centre, half = meeting([sight_of_object(one) for one in cones])
        bounds = _hull_box(cones, centre, half)
    else:
        centre, half = meeting([sight_of_picture(one) for one in photographs])
        bounds = None
    if bounds is None:
        return _about(np.stack([centre - half, centre + half]), told=False)
    return _about(np.stack(bounds), told=True)


def _about(box: Float[np.ndarray, "2 3"], *, told: bool) -> Region:
    half = 0.5 * (1.0 + MARGIN) * float((box[1] - box[0]).max())
    return Region(box.mean(axis=0), half, box if told else None)


def _hull_box(
    cones: Sequence[Cone], centre: Float[np.ndarray, "3"], half: float
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]] | None:
    """Lowest and highest corner of what the masks leave [m]; None where that is nothing."""
    for _ in range(_GROWN):
        found = carve(cones, voxels_in(centre - half, centre + half, _COARSE))
        left = _left(found)
        if left is None:
            return None
        inside = half - 0.5 * found.voxels.edge
        if np.all(left[0] > centre - inside) and np.all(left[1] < centre + inside):
            break
        half *= 2.0
    low, high = left
    return _left(carve(cones, voxels_in(low, high, _COARSE)))


def _left(carving: Carving) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]] | None:
    """Box of the voxels that the fewest photographs deny, or None if that is half of them."""
    denials = carving.denials()
    fewest = denials.min()
    if 2 * fewest >= len(carving.numbers):
        return None
    middles = carving.voxels.middles()[denials == fewest]
    half = 0.5 * carving.voxels.edge
    return middles.min(axis=0) - half, middles.max(axis=0) + half


def _checked(box: object) -> Float[np.ndarray, "2 3"]:
    corners = real_array(box, where="box", quantity="corners of the box [m]")
    if corners.shape != (2, 3) or not (corners[0] < corners[1]).all() or np.isinf(corners).any():
        raise InputError(
            "this is no box", where="box", value=corners.tolist(),
            limit="two corners [m] of three finite numbers, each of the first below the second's",
            remedy="give [[x_min, y_min, z_min], [x_max, y_max, z_max]] in metres",
        )  # fmt: skip
    return corners

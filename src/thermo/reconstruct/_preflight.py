"""Checks of photographs, masks, poses and bounds before hours are spent on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import trimesh
from jaxtyping import Float

from thermo.imaging import project

from ._contradictions import explained
from ._finding import Finding
from ._photograph import Photograph
from ._region import Region

_FEW: Final = 8
"""Photographs below which an object is seldom rebuilt [1]."""
_SMALL: Final = 24
"""Pixels across the object below which detail is lost [px]."""
_MISSED: Final = 0.05
"""Share of a mask that the others may leave no room for [1]: what voxels and edges blur."""
_UNSEEN: Final = -0.2
"""Cosine from a side to the nearest camera's below which nobody sees that side [1]."""
_SIZES: Final = (1e-3, 20.0)
"""Edges of a region [m] beyond which its unit is doubted."""


def preflight(photographs: Sequence[Photograph], region: Region) -> tuple[Finding, ...]:
    """What would spoil a training on these photographs, the worst first.

    Looks at each camera (whether it looks at the region, stands in it or twice in one place), each
    mask (empty, filled, inverted, cut by the picture's edge, too small), at whether masks and poses
    of all photographs contradict each other, at sides that nobody sees and at the unit of length.

    Arguments: `photographs`: to be trained on. `region`: the cube [m] that is to hold the object.

    Returns nothing where all is well. Sizes that differ from the camera's were refused by
    `Photograph`, and mixed masks are by `train`.
    """
    found = [
        *_few(photographs),
        *_unit(region),
        *_looks(photographs, region),
        *_twice(photographs, region),
        *_masks(photographs),
        *_contradictions(photographs, region),
        *_unseen(photographs, region),
    ]
    return tuple(sorted(found, key=lambda one: not one.fatal))


def _few(photographs: Sequence[Photograph]) -> Iterator[Finding]:
    count = len(photographs)
    if count < _FEW:
        yield Finding(
            f"there are {count} photographs", "cameras",
            f"take {_FEW} and more, from all sides", fatal=count < 2,
        )  # fmt: skip


def _unit(region: Region) -> Iterator[Finding]:
    edge = 2.0 * region.half
    if not _SIZES[0] <= edge <= _SIZES[1]:
        yield Finding(
            f"the region's edge is {edge:.3g} m", "camera_scale",
            "give the length of the cameras' unit, or a scale, if lengths are not metres",
            fatal=False,
        )  # fmt: skip


def _looks(photographs: Sequence[Photograph], region: Region) -> Iterator[Finding]:
    """Cameras that see nothing of the region, and those that stand in it."""
    corners = region.centre + region.half * (np.indices((3, 3, 3)).reshape(3, -1).T - 1.0)
    away = []
    for one in photographs:
        camera = one.camera
        pixels, depth = project(camera, corners)
        size = np.array([camera.width, camera.height])
        with np.errstate(invalid="ignore"):
            seen = ((pixels > -0.5) & (pixels < size - 0.5)).all(axis=1) & (depth > 0)
        if np.abs(camera.place() - region.centre).max() < region.half:
            yield Finding(
                "the camera stands inside the region", one.file,
                "give a smaller box, and see whether camera_scale is right", fatal=True,
            )  # fmt: skip
        elif not seen.any():
            away.append((one, bool((depth <= 0).all())))
    behind = sum(turned for _, turned in away)
    if 2 * behind > len(photographs):
        yield Finding(
            f"{behind} of {len(photographs)} cameras look away from where their lines meet",
            "cameras",
            "the poses have other axes than the format says: give camera_axes=opengl or opencv",
            fatal=True,
        )  # fmt: skip
        return
    for one, _ in away:
        yield Finding(
            "the region is out of the picture", one.file,
            "see whether its pose is that of this picture, or give a box", fatal=False,
        )  # fmt: skip


def _twice(photographs: Sequence[Photograph], region: Region) -> Iterator[Finding]:
    places = np.stack([one.camera.place() for one in photographs])
    for number, one in enumerate(photographs):
        gap = np.linalg.norm(places[:number] - places[number], axis=1)
        alike = [
            other.file
            for other, apart in zip(photographs[:number], gap, strict=True)
            if apart < 1e-6 * region.half and np.allclose(other.camera.pose, one.camera.pose)
        ]
        if alike:
            yield Finding(
                f"the camera stands and looks as that of {alike[0]}", one.file,
                "give each picture its own pose, and each pose once", fatal=False,
            )  # fmt: skip


def _masks(photographs: Sequence[Photograph]) -> Iterator[Finding]:
    """Masks that tell nothing, or the wrong thing."""
    for one in photographs:
        if one.mask is None:
            continue
        shown = one.mask > 0.5
        rim = np.concatenate([shown[0], shown[-1], shown[:, 0], shown[:, -1]])
        if not shown.any():
            yield Finding(
                "its mask shows no object", one.file,
                "mend the mask or the threshold, or leave the picture out", fatal=True,
            )  # fmt: skip
        elif rim.mean() > 0.5:
            yield Finding(
                "its mask covers most of the picture's edge", one.file,
                "masks are bright on the object: invert it, or raise the threshold", fatal=True,
            )  # fmt: skip
        elif rim.any():
            yield Finding(
                "the picture's edge cuts the object", one.file,
                "take it from farther away: what is cut counts as empty", fatal=False,
            )  # fmt: skip
        elif np.sqrt(shown.sum()) < _SMALL:
            yield Finding(
                f"the object is {np.sqrt(shown.sum()):.0f} pixels across", one.file,
                "take it from nearer, or in more pixels", fatal=False,
            )  # fmt: skip


def _contradictions(photographs: Sequence[Photograph], region: Region) -> Iterator[Finding]:
    shares = explained(photographs, region)
    if len(shares) < 3:
        return
    values = np.array(list(shares.values()))
    if np.median(values) < 1.0 - _MISSED:
        yield Finding(
            f"in most photographs less than {np.median(values):.0%} of the object can be where "
            "the others see it", "cameras",
            "see whether poses belong to these pictures, in this order and these axes, and "
            "whether the box holds the object", fatal=bool(np.median(values) < 0.5),
        )  # fmt: skip
        return
    for number, share in shares.items():
        if share < 1.0 - _MISSED:
            yield Finding(
                f"{1 - share:.0%} of the object in it is where the others see none",
                photographs[number].file,
                "its pose or its mask is wrong: mend it or leave the picture out", fatal=False,
            )  # fmt: skip


def _unseen(photographs: Sequence[Photograph], region: Region) -> Iterator[Finding]:
    sides: Float[np.ndarray, "sides 3"] = np.asarray(trimesh.creation.icosphere(2).vertices)
    ways = np.stack([one.camera.place() - region.centre for one in photographs])
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-300)
    nearest = (sides @ ways.T).max(axis=1)
    worst = int(np.argmin(nearest))
    if nearest[worst] < _UNSEEN:
        towards = ", ".join(f"{one:.1f}" for one in sides[worst])
        yield Finding(
            f"no camera sees the object from ({towards})", "cameras",
            "take photographs from there: that side is rebuilt from silhouettes alone at the best",
            fatal=False,
        )  # fmt: skip

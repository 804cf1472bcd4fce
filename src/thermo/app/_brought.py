"""A surface brought to where silhouettes or a cloud of points show it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from thermo.errors import InputError
from thermo.imaging import (
    Alignment,
    Camera,
    Frames,
    PointAlignment,
    align_to_points,
    align_to_silhouettes,
    check_cloud,
    mask_of,
    read_points,
)
from thermo.mesh import Surface
from thermo.observe import Scene

CHOICES = ("pose", "pose_and_scale")
_MOST = 0.5  # 1, to which a scene may leave its scale open


class Brought(NamedTuple):
    """A surface [m] where it was brought to, how it was found, and that in words."""

    surface: Surface
    found: Alignment | PointAlignment
    words: list[str]


def cloud_of(settings: Mapping[str, Any], surface: Surface) -> Float[np.ndarray, "points 3"] | None:
    """The points [m] that the settings name; None without any.

    Raises `InputError` where they, their unit or the rest of the settings make no sense.
    """
    path, unit = settings["points"], settings["points_unit"]
    if path is None:
        if unit is not None:
            raise InputError(
                "there are no points that could have a unit", where="points_unit", value=unit,
                limit="null without points", remedy="give points=FILE, or leave it out",
            )  # fmt: skip
        return None
    if settings["align"] is None:
        raise InputError(
            "nothing is brought to the points", where="points", value=path,
            limit=f"align={' or '.join(CHOICES)} beside points",
            remedy="give align=pose, or leave points out",
        )  # fmt: skip
    if unit == "cameras" and settings["camera_scale"] is None:
        raise InputError(
            "the length of the cameras' unit is wanted", where="camera_scale", value="null",
            limit="metres, beside points_unit=cameras",
            remedy="give camera_scale=0.001 where their unit is a millimetre, also where their "
            "file says so; or points_unit=m, cm, mm or inch",
        )  # fmt: skip
    if unit is None:
        raise InputError(
            "the unit of the points is not known", where="points_unit", value="null",
            limit="m, cm, mm or inch; or cameras, where camera_scale says how long that is",
            remedy="state the unit of the coordinates in the file",
        )  # fmt: skip
    cloud = read_points(
        Path(str(path)), unit=float(settings["camera_scale"]) if unit == "cameras" else str(unit)
    )
    check_cloud(surface, cloud, where=str(path))
    return cloud


def to_points(
    settings: Mapping[str, Any], surface: Surface, cloud: Float[np.ndarray, "points 3"]
) -> Brought:
    """The surface where a cloud shows it. Raises `InputError` where the two do not meet."""
    where = str(settings["points"])
    found = align_to_points(
        surface, cloud, scale=settings["align"] == "pose_and_scale", where=where
    )
    if not found.success:
        raise InputError(
            "the surface could not be brought to the points", where=where, value=found.reason,
            limit="half of the points on the surface, to a hundredth of its size",
            remedy="cut away what is not the object, look at points_unit, and begin nearer: some "
            "20 degrees and a tenth of the size",
        )  # fmt: skip
    left = (
        f"points {1e3 * found.residual:.3g} mm off the surface, {found.inliers:.0%} of them within "
        "three times that"
    )
    return _brought(settings, surface, found, left, "points")


def to_silhouettes(
    settings: Mapping[str, Any],
    surface: Surface,
    cameras: Sequence[Camera],
    frames: Sequence[Frames],
    files: Sequence[Path],
) -> Brought:
    """The surface where frames' silhouettes show it.

    Raises `InputError` where the silhouettes do not meet.
    """
    masks = [mask_of(one, where=str(file)) for one, file in zip(frames, files, strict=True)]
    found = align_to_silhouettes(
        surface, cameras, masks, scale=settings["align"] == "pose_and_scale"
    )
    overlap = (
        f"overlap {found.overlap_before.min():.3f} before, {found.overlap_after.min():.3f} after"
    )
    if not found.success:
        raise InputError(
            "the surface could not be brought to the silhouettes", where="align",
            value=f"{found.reason}; {overlap}", limit="silhouettes that meet to about a pixel",
            remedy="check that nothing else warm is in view, that frames=[a,b] stand in the order "
            "of the cameras, and begin nearer",
        )  # fmt: skip
    left = f"{overlap}, {found.residual:.2f} px left"
    return _brought(settings, surface, found, left, "silhouettes")


def with_scale(settings: Mapping[str, Any], scene: Scene, brought: Brought) -> Scene:
    """The scene, which says how well the scale is known to which its surface was brought [1].

    A deviation that is stated counts. Else a scale that was free has that of the alignment, and
    that of the surface's own beside it, in squares: the surface's scale then is that of the
    cameras, which are as a rule in the world of which it was rebuilt, and known no better.

    Raises `InputError` where neither says how large the object is.
    """
    if settings["align"] != "pose_and_scale" or settings["scale_deviation"] is not None:
        return scene
    total = math.hypot(scene.scale_deviation, float(brought.found.deviation[6]))
    untold = [one for one in brought.found.untold if one.startswith("scale")]
    if untold or total > _MOST:
        raise InputError(
            "the scale is not told by what the surface was brought to", where="align",
            value="; ".join(untold) or f"known to {100 * total:.0f} %",
            limit=f"a scale that is known to {100 * _MOST:g} %",
            remedy="give align=pose, which keeps the surface's own, another view, or state "
            "scale_deviation",
        )  # fmt: skip
    return replace(scene, scale_deviation=total)


def _brought(
    settings: Mapping[str, Any],
    surface: Surface,
    found: Alignment | PointAlignment,
    left: str,
    source: str,
) -> Brought:
    moved = found.similarity
    angle = np.degrees(Rotation.from_matrix(moved.rotation).magnitude())
    middle = surface.vertices.mean(axis=0)
    shift = 1e3 * float(np.linalg.norm(moved.apply(middle[None])[0] - middle))
    rotation, place = found.deviation[:3].max(), 1e3 * found.deviation[3:6].max()
    known = f"known to {np.degrees(rotation):.2g} degrees and {place:.2g} mm"
    if settings["align"] == "pose_and_scale":
        known += f", the scale to {100 * found.deviation[6]:.2g} %"
    words = [
        f"aligned: turned by {angle:.2f} degrees, moved by {shift:.2f} mm, scaled by "
        f"{moved.scale:.4f}; {left}",
        f"{known} (one standard deviation)",
    ]
    words += [f"not told by the {source}: {one}" for one in found.untold]
    return Brought(Surface(moved.apply(surface.vertices), surface.triangles), found, words)

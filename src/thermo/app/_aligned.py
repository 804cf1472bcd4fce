"""Frames and surface brought together: the object's pose, and the time of the lamp."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from thermo.app._configuration import flag
from thermo.errors import InputError
from thermo.imaging import (
    Camera,
    Frames,
    SurfaceSamples,
    align_to_silhouettes,
    fused,
    mask_of,
    time_offset,
)
from thermo.mesh import Surface

CHOICES = ("pose", "pose_and_scale")
AFTER = 10.0  # s, what `time_offset` looks at after a switch


def check_alignment(settings: Mapping[str, Any]) -> None:
    """Refuse an alignment or a search for the lamp's time that cannot be. Raises `InputError`."""
    choice = settings["align"]
    if choice is not None and choice not in CHOICES:
        raise InputError(
            "there is no such alignment", where="align", value=choice,
            limit=f"null, {', '.join(CHOICES)}", remedy="give align=pose",
        )  # fmt: skip
    if choice is not None and settings["scene"] is not None:
        raise InputError(
            "the surface of a scene that stands is not moved", where="align", value=choice,
            limit="null beside scene=FOLDER", remedy="give surface=FILE, or poses that fit it",
        )  # fmt: skip
    if flag(settings, "find_lamp_time") and settings["heater"] is None:
        raise InputError(
            "there is no lamp whose time could be found", where="find_lamp_time", value=True,
            limit="false without a heater", remedy="give heater={...}",
        )  # fmt: skip


def aligned(
    settings: Mapping[str, Any],
    surface: Surface,
    cameras: Sequence[Camera],
    frames: Sequence[Frames],
    files: Sequence[Path],
) -> tuple[Surface, list[str]]:
    """The surface where the frames' silhouettes show it, and what is known of that, in words.

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
    moved = found.similarity
    angle = np.degrees(Rotation.from_matrix(moved.rotation).magnitude())
    middle = surface.vertices.mean(axis=0)
    shift = 1e3 * float(np.linalg.norm(moved.apply(middle[None])[0] - middle))
    words = [
        f"aligned: turned by {angle:.2f} degrees, moved by {shift:.2f} mm, scaled by "
        f"{moved.scale:.4f}; {overlap}, {found.residual:.2f} px left"
    ]
    words += [f"not told by the silhouettes: {one}" for one in found.untold]
    return Surface(moved.apply(surface.vertices), surface.triangles), words


def on_time(
    settings: Mapping[str, Any],
    samples: SurfaceSamples,
    cameras: Sequence[Camera],
    frames: Sequence[Frames],
) -> tuple[list[Frames], list[str]]:
    """Frames whose time 0 is when the lamp went on, as the frames themselves show it.

    Raises `InputError` where no onset is seen.
    """
    time, temperature = fused(samples, cameras, frames, together=settings["together"])
    last = float(settings["heater"]["until"])
    # A switch is seen by what comes after it as well.
    switches = [0.0, last] if last + AFTER < time[-1] else [0.0]
    found = time_offset(time, temperature, switches, where="find_lamp_time")
    shifted = [
        Frames(one.time - found.offset, one.values, one.valid, where=camera.name)
        for one, camera in zip(frames, cameras, strict=True)
    ]
    return shifted, [
        f"the lamp went on {found.offset:.3f} s after the stated time 0 (deviation "
        f"{found.deviation:.3f} s); frames were moved by that"
    ]


def write_surface(surface: Surface, path: Path) -> None:
    """Write a surface as PLY [m]."""
    trimesh.Trimesh(surface.vertices, surface.triangles, process=False).export(path)

"""Two cameras that are fixed to each other, as a colour camera beside a thermal one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.observe import real_array

from ._camera import Camera
from ._json_file import read_table, write_table
from ._pose import checked_pose
from ._view import View

FORMAT: Final = "thermofield-rig/1"
"""Format of the file of a rig."""


@final
class Rig(eqx.Module):
    """A thermal camera that moves with a colour camera; all leaves are NumPy arrays.

    Arguments:

    - `width`, `height`: of the thermal frames [px].
    - `focal`, `centre`: of the thermal camera [px]. `distortion`: k1, k2, p1, p2, k3 of it [1].
    - `colour_to_thermal`: from the axes of the colour camera to those of the thermal one, both
      OpenCV's, (4, 4), its last column in metres.
    - `where`: what messages call it.

    Raises `InputError` as `Camera` does.
    """

    thermal: Camera

    def __init__(
        self,
        width: int,
        height: int,
        focal: Sequence[float] | Float[np.ndarray, "2"],
        centre: Sequence[float] | Float[np.ndarray, "2"],
        colour_to_thermal: Float[np.ndarray, "4 4"],
        distortion: Sequence[float] | Float[np.ndarray, "5"] = (0.0, 0.0, 0.0, 0.0, 0.0),
        *,
        where: str = "rig",
    ) -> None:
        # In the axes of the colour camera: its pose is the transformation between the two.
        self.thermal = Camera(
            width, height, focal, centre, colour_to_thermal, distortion, name="thermal",
            where=where,
        )  # fmt: skip

    def colour_to_thermal(self) -> Float[np.ndarray, "4 4"]:
        """From the colour camera's axes to the thermal camera's [m]."""
        return self.thermal.pose


def thermal_views(rig: Rig, views: Sequence[View]) -> tuple[View, ...]:
    """The thermal camera beside each of the colour camera's views [m].

    The names of files are the colour camera's: what the thermal camera recorded is for the caller
    to say.
    """
    return tuple(
        eqx.tree_at(lambda one: one.camera, view, _beside(rig.thermal, view.camera))
        for view in views
    )


def _beside(thermal: Camera, colour: Camera) -> Camera:
    return Camera(
        thermal.width, thermal.height, thermal.focal, thermal.centre, thermal.pose @ colour.pose,
        thermal.distortion, name=colour.name,
    )  # fmt: skip


def rig_from_poses(
    thermal: Sequence[View], colour: Sequence[View], *, where: str = "rig"
) -> tuple[Rig, float, float]:
    """The rig that brings colour cameras to thermal ones, from poses of both in one world.

    Each pair tells the transformation anew. The rotation is their mean (the rotation nearest to the
    sum), the shift the mean shift.

    Returns the rig, and how far the pairs stray from it, root mean square: angles [deg] and shifts
    [m]. Raises `InputError` where their numbers differ.
    """
    if len(thermal) != len(colour) or not thermal:
        raise InputError(
            "thermal and colour cameras do not pair up", where=where,
            value=f"{len(thermal)} and {len(colour)}", limit="one of each a moment",
            remedy="leave out pictures that the other camera lacks",
        )  # fmt: skip
    between = np.array(
        [one.camera.pose @ np.linalg.inv(two.camera.pose)
         for one, two in zip(thermal, colour, strict=True)]
    )  # fmt: skip
    left, _, right = np.linalg.svd(between[:, :3, :3].sum(axis=0))
    mean = np.eye(4)
    mean[:3, :3] = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    mean[:3, 3] = between[:, :3, 3].mean(axis=0)
    turned = between[:, :3, :3] @ mean[:3, :3].T
    # The sine tells small angles to rounding, where the cosine loses half of the digits.
    skew = turned - turned.transpose(0, 2, 1)
    sine = np.linalg.norm(skew[:, [2, 0, 1], [1, 2, 0]], axis=1) / 2
    angle = np.arctan2(sine, (np.trace(turned, axis1=1, axis2=2) - 1) / 2)
    off = np.linalg.norm(between[:, :3, 3] - mean[:3, 3], axis=1)
    first = thermal[0].camera
    rig = Rig(
        first.width, first.height, first.focal, first.centre, mean, first.distortion, where=where
    )
    return rig, float(np.degrees(np.sqrt(np.mean(angle**2)))), float(np.sqrt(np.mean(off**2)))


def write_rig(path: Path | str, rig: Rig) -> None:
    """Write a rig as JSON, its shift in metres [m]. Raises `InputError` as `write_transforms`."""
    camera = rig.thermal
    write_table(
        Path(path),
        {
            "format": FORMAT,
            "thermal": {
                "width": camera.width,
                "height": camera.height,
                "focal": camera.focal.tolist(),
                "centre": camera.centre.tolist(),
                "distortion": camera.distortion.tolist(),
            },
            "colour_to_thermal": camera.pose.tolist(),
        },
    )


def read_rig(path: Path | str) -> Rig:
    """The rig in a JSON file [m]. Raises `InputError` for what is missing or cannot be."""
    table = read_table(Path(path), what="the rig")
    if table.get("format") != FORMAT:
        raise InputError(
            "this is no rig", where=f"{path}: format", value=table.get("format"), limit=FORMAT,
            remedy="write it with thermo.imaging.write_rig",
        )  # fmt: skip
    known: dict[str, Any] = table["thermal"] if isinstance(table.get("thermal"), dict) else {}
    wanted = {"width", "height", "focal", "centre", "distortion"}
    if set(known) != wanted or "colour_to_thermal" not in table:
        raise InputError(
            "this rig lacks a part", where=str(path), value=", ".join([*table, *known]),
            limit="thermal with " + ", ".join(sorted(wanted)) + "; colour_to_thermal",
            remedy="write it with thermo.imaging.write_rig",
        )  # fmt: skip
    numbers = {
        key: real_array(known[key], where=f"{path}: thermal.{key}", quantity=key).ravel().tolist()
        for key in ("focal", "centre", "distortion")
    }
    return Rig(
        known["width"], known["height"], numbers["focal"], numbers["centre"],
        checked_pose(table["colour_to_thermal"], where=f"{path}: colour_to_thermal"),
        numbers["distortion"], where=str(path),
    )  # fmt: skip

"""The cameras that a command was given."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from thermo.errors import InputError
from thermo.imaging import Axes, View, read_cameras, read_rig, thermal_views
from thermo.observe import check_number


def cameras_of(settings: Mapping[str, Any]) -> tuple[View, ...]:
    """Cameras of `cameras`, in the unit and the axes that are stated, of a rig where there is one.

    Raises `InputError` for settings that make no sense, and as `read_cameras` does.
    """
    axes = settings["camera_axes"]
    known = [one.value for one in Axes]
    if axes is not None and axes not in known:
        raise InputError(
            "these axes are not known", where="camera_axes", value=axes, limit=", ".join(known),
            remedy="leave camera_axes out: each format says which axes it has",
        )  # fmt: skip
    scale = settings["camera_scale"]
    if scale is not None:
        scale = check_number(
            scale, where="camera_scale", quantity="length of the cameras' unit [m]", above=0.0,
            remedy="give metres, 0.001 for millimetres, or leave it out",
        )  # fmt: skip
    views = read_cameras(
        Path(settings["cameras"]), scale=scale, axes=None if axes is None else Axes(axes)
    )
    # Not every verb has thermal cameras.
    rig = settings.get("rig")
    return views if rig is None else thermal_views(read_rig(Path(str(rig))), views)

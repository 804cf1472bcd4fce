"""The cameras that a command was given."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from thermo.errors import InputError
from thermo.imaging import Axes, View, read_cameras, read_rig, thermal_views


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
    views = read_cameras(
        Path(settings["cameras"]), scale=settings["camera_scale"],
        axes=None if axes is None else Axes(axes),
    )  # fmt: skip
    rig = settings["rig"]
    return views if rig is None else thermal_views(read_rig(Path(rig)), views)

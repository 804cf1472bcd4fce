"""What alignments are possible, the time of the lamp, and a surface that was moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import trimesh

from thermo.app._brought import CHOICES
from thermo.app._configuration import flag
from thermo.errors import InputError
from thermo.imaging import (
    Camera,
    Frames,
    SurfaceSamples,
    fused,
    time_offset,
)
from thermo.mesh import Surface

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

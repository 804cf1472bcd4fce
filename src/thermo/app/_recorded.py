"""What cameras recorded, as the settings of a command name and state it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from thermo.app._configuration import flag, given
from thermo.errors import InputError
from thermo.imaging import (
    Band,
    Frames,
    Optics,
    PlanckConstants,
    Stated,
    View,
    check_count,
    check_frames,
    find_faults,
    read_frames,
    to_temperature,
    without_faults,
)

Radiometry = tuple[Band | PlanckConstants, Optics]

OF_NO_USE = (
    "reflected_temperature", "air_temperature", "window_temperature",
    "window_reflected_temperature", "planck",
)  # fmt: skip
"""What counts for nothing without an emissivity."""


def files_of(settings: Mapping[str, Any], views: Sequence[View]) -> list[Path]:
    """The recording of each camera: `frames`, or what the cameras' file names. Raises `InputError`.

    None of them is read.
    """
    if settings["frames"] is None:
        files = _beside(Path(settings["cameras"]), views)
    else:
        listed = settings["frames"]
        files = [Path(str(one)) for one in (listed if isinstance(listed, list) else [listed])]
    check_count(len(files), len(views), where="frames")
    for file in files:
        if not file.exists():
            raise InputError(
                "the frames are not there", where=str(file), value="no such file or folder",
                limit="a recording that can be read", remedy="check frames=[...]",
            )  # fmt: skip
    return files


def stated_of(settings: Mapping[str, Any]) -> tuple[dict[str, Any], bool]:
    """What is stated of the recordings, and whether faults are left out. Raises `InputError`."""
    stated = dict(settings["recording"])
    mend = flag(stated, "faults", "recording.")
    del stated["faults"]
    if stated["times"] is not None and not isinstance(stated["times"], list):
        stated["times"] = _times(Path(str(stated["times"])))
    Stated(**stated, where="recording")
    return stated, mend


def radiometry_of(settings: Mapping[str, Any]) -> Radiometry | None:
    """What lies between the object's temperature and the frames'; None where nothing does.

    Raises `InputError` for what makes no sense.
    """
    optics = dict(settings["optics"])
    band, planck = optics.pop("band"), optics.pop("planck")
    if optics["emissivity"] is None:
        _no_optics(optics | {"planck": planck})
        return None
    known: dict[str, Any] = given(optics, "optics.")
    if planck is None:
        return Band(*band), Optics(**known)
    if not isinstance(planck, Mapping) or set(planck) != {"r1", "r2", "b", "f", "o"}:
        raise InputError(
            "these are no constants of Planck's law", where="optics.planck", value=planck,
            limit="r1, r2, b, f and o", remedy="take them from the camera's calibration",
        )  # fmt: skip
    constants: dict[str, Any] = given(planck, "optics.planck.")
    return PlanckConstants(**constants, where="optics.planck"), Optics(**known)


def frames_of(
    settings: Mapping[str, Any],
    stated: Mapping[str, Any],
    mend: bool,
    radiometry: Radiometry | None,
    file: Path,
    view: View,
) -> tuple[Frames, list[str]]:
    """The temperatures [K] in a camera's file, and what was found to be wrong with it, in words.

    Raises `InputError` where it cannot be read, or is not of that camera.
    """
    # A camera that moves has one picture a place, taken at the time that its file of poses says.
    if view.time is not None:
        stated = {**stated, "start": view.time, "rate": stated["rate"] or 1.0}
    try:
        frames = read_frames(file, Stated(**stated, where="recording"))
    except InputError as error:
        if settings["frames"] is not None:
            raise
        raise InputError(
            error.what, where=error.where, value=error.value, limit=error.limit,
            remedy="the cameras' file names it: where that is a photograph, name the thermal "
            f"recordings by frames=[a,b] in the order of the cameras; else {error.remedy}",
        ) from error  # fmt: skip
    words: list[str] = []
    if mend and len(frames.time) > 2:
        faults = find_faults(frames)
        frames, words = without_faults(frames, faults), list(faults.sentences())
    if radiometry is not None:
        counted = isinstance(radiometry[0], PlanckConstants)
        if frames.counts != counted:
            raise InputError(
                "frames and radiometry do not go together", where=str(file),
                value="counts" if frames.counts else "temperatures, with optics.planck",
                limit="counts with the maker's constants, or apparent temperatures without",
                remedy="give optics.planck={r1:..,r2:..,b:..,f:..,o:..} for counts, and for them "
                "alone",
            )  # fmt: skip
        frames = to_temperature(frames, *radiometry, where=str(file))
    check_frames([view.camera], [frames], str(file))
    return frames, words


def _beside(cameras: Path, views: Sequence[View]) -> list[Path]:
    """The files that the cameras' file names, which lie beside it."""
    without = [view.camera.name for view in views if not view.file]
    if without:
        raise InputError(
            "these cameras name no recording", where=str(cameras), value=", ".join(without[:6]),
            limit="a file for each camera, here or in `frames`",
            remedy="give frames=[a,b] in the order of the cameras",
        )  # fmt: skip
    folder = cameras if cameras.is_dir() else cameras.parent
    return [folder / view.file for view in views]


def _times(file: Path) -> np.ndarray:
    try:
        return np.loadtxt(file, ndmin=1, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise InputError(
            "these times cannot be read", where="recording.times",
            value=f"{file}: {' '.join(str(error).split())[:120]}",
            limit="a list of seconds, or a text file with one a line",
            remedy="give recording.times=[0,0.5,1], or the name of such a file",
        ) from error  # fmt: skip


def _no_optics(optics: Mapping[str, Any]) -> None:
    """Refuse surroundings that are stated without an emissivity: they would count for nothing."""
    stated = [key for key, value in optics.items() if value is not None and key in OF_NO_USE]
    if stated:
        raise InputError(
            "the emissivity is missing", where="optics.emissivity", value="null",
            limit=f"a share from 0 to 1 beside {', '.join(stated)}",
            remedy="give optics.emissivity, or leave the other settings of optics out",
        )  # fmt: skip

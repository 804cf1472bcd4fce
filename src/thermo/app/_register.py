"""`thermo register`: frames of calibrated cameras become a scene folder."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from thermo.app._aligned import aligned, check_alignment, on_time, write_surface
from thermo.app._cameras import cameras_of
from thermo.app._configuration import given, number
from thermo.app._stated_scene import (
    check_conditions,
    check_room,
    compare_start,
    run_of,
    scene_of_settings,
    surface_of_settings,
)
from thermo.errors import InputError
from thermo.imaging import (
    Band,
    Camera,
    Frames,
    Optics,
    PlanckConstants,
    Stated,
    SurfaceSamples,
    View,
    check_frames,
    coverage,
    find_faults,
    place_samples,
    read_frames,
    register_frames,
    to_temperature,
    without_faults,
)
from thermo.mesh import Surface
from thermo.observe import Recording, write_scene
from thermo.report import require_writable, write_registration

Radiometry = tuple[Band | PlanckConstants, Optics]

OF_NO_USE = (
    "reflected_temperature", "air_temperature", "window_temperature",
    "window_reflected_temperature", "planck",
)  # fmt: skip
"""What counts for nothing without an emissivity."""


def register(settings: Mapping[str, Any]) -> None:
    """Bring frames to a surface, and leave a scene folder and how each sample was read."""
    out = Path(settings["out"])
    views = cameras_of(settings)
    surface, surface_path = surface_of_settings(settings)
    check_conditions(settings)
    check_room(settings)
    check_alignment(settings)
    radiometry = _radiometry(settings)
    files = _files(settings, views)
    cameras = [view.camera for view in views]
    samples = _samples(settings, surface, cameras)
    print(f"reading {len(files)} recordings", file=sys.stderr)
    read = [
        _frames(settings, file, view, radiometry) for file, view in zip(files, views, strict=True)
    ]
    frames = [one for one, _ in read]
    told = [
        f"{file}: {word}" for file, (_, words) in zip(files, read, strict=True) for word in words
    ]
    where = str(settings["frames"] or settings["cameras"])
    for camera, one, file in zip(cameras, frames, files, strict=True):
        check_frames([camera], [one], str(file))
    if settings["align"] is not None:
        surface, words = aligned(settings, surface, cameras, frames, files)
        samples = _samples(settings, surface, cameras)
        told += words
    if settings["find_lamp_time"]:
        frames, words = on_time(settings, samples, cameras, frames)
        told += words
    recording = register_frames(
        samples, cameras, frames, together=number(settings, "together"), where=where
    )
    run = run_of(settings, recording)
    told += compare_start(run)
    with tempfile.TemporaryDirectory() as folder:
        if settings["align"] is not None:
            surface_path = Path(folder) / "surface.ply"
            write_surface(surface, surface_path)
            settings = {**settings, "unit": "m"}
        scene = scene_of_settings(settings, surface_path, run)
        require_writable(out)
        write_scene(out, scene)
    seen = coverage(surface, cameras, **_limits(settings))
    record = write_registration(out, run.name, cameras, samples, seen, told, settings)
    print(_table(recording, record, out))


def _samples(
    settings: Mapping[str, Any], surface: Surface, cameras: Sequence[Camera]
) -> SurfaceSamples:
    picked = settings["samples"]
    return place_samples(
        surface, cameras, count=number(picked, "count", "samples.", whole=True, above=0),
        where=str(settings["cameras"]), **_limits(settings),
    )  # fmt: skip


def _limits(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Which pixels are used."""
    picked = settings["samples"]
    return {
        "grazing": number(picked, "grazing", "samples."),
        "margin": number(picked, "margin", "samples.", whole=True, above=-1),
    }


def _files(settings: Mapping[str, Any], views: Sequence[View]) -> list[Path]:
    """The recording of each camera."""
    given_files = settings["frames"]
    beside = Path(settings["cameras"])
    beside = beside if beside.is_dir() else beside.parent
    if given_files is None:
        found = [beside / view.file if view.file else None for view in views]
    else:
        listed = given_files if isinstance(given_files, list) else [given_files]
        found = [Path(str(one)) for one in listed]
    if len(found) != len(views) or None in found:
        raise InputError(
            "frames and cameras differ in number", where="frames",
            value=f"{len([one for one in found if one])} recordings, {len(views)} cameras",
            limit="one recording a camera", remedy="give frames=[a,b] in the order of the cameras",
        )  # fmt: skip
    files = [one for one in found if one is not None]
    for file in files:
        if not file.exists():
            raise InputError(
                "the frames are not there", where=str(file), value="no such file or folder",
                limit="a recording that can be read", remedy="check frames=[...]",
            )  # fmt: skip
    return files


def _frames(
    settings: Mapping[str, Any], file: Path, view: View, radiometry: Radiometry | None
) -> tuple[Frames, list[str]]:
    """The temperatures in a file, and what was found to be wrong with it."""
    stated = dict(settings["recording"])
    mend = stated.pop("faults")
    # A camera that moves has one picture a place, taken at the time that its file of poses says.
    if view.time is not None:
        stated |= {"start": view.time, "rate": stated["rate"] or 1.0}
    frames = read_frames(file, Stated(**stated, where="recording"))
    words: list[str] = []
    if mend and len(frames.time) > 2:
        faults = find_faults(frames)
        frames, words = without_faults(frames, faults), list(faults.sentences())
    if radiometry is None:
        return frames, words
    counted = isinstance(radiometry[0], PlanckConstants)
    if frames.counts != counted:
        raise InputError(
            "frames and radiometry do not go together", where=str(file),
            value="counts" if frames.counts else "temperatures, with optics.planck",
            limit="counts with the maker's constants, or apparent temperatures without",
            remedy="give optics.planck={r1:..,r2:..,b:..,f:..,o:..} for counts, and for them alone",
        )  # fmt: skip
    return to_temperature(frames, *radiometry, where=str(file)), words


def _radiometry(settings: Mapping[str, Any]) -> Radiometry | None:
    """What lies between the object's temperature and the frames'; None where nothing does."""
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


def _no_optics(optics: Mapping[str, Any]) -> None:
    """Refuse surroundings that are stated without an emissivity: they would count for nothing."""
    stated = [key for key, value in optics.items() if value is not None and key in OF_NO_USE]
    if stated:
        raise InputError(
            "the emissivity is missing", where="optics.emissivity", value="null",
            limit=f"a share from 0 to 1 beside {', '.join(stated)}",
            remedy="give optics.emissivity, or leave the other settings of optics out",
        )  # fmt: skip


def _table(recording: Recording, record: Mapping[str, Any], out: Path) -> str:
    """What a person reads at the end."""
    rows = []
    for name, one in record["cameras"].items():
        pixel = one["footprint"]
        size = "" if pixel is None else f", one pixel {1e3 * pixel:.2g} mm there"
        rows.append(f"{name}: {one['samples']} samples{size}")
    quiet = 0 if recording.quiet is None else len(recording.quiet)
    usable = 100 * float(recording.valid.mean())
    rows.append(
        f"{len(recording.time)} moments and {quiet} before the start, {usable:.1f} % of readings "
        "usable"
    )
    rows.append(f"cameras read {100 * record['coverage']:.0f} % of the surface")
    return "\n".join([*rows, *record["told"], str(out / "scene.json")])

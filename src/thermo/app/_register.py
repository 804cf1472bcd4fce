"""`thermo register`: frames of calibrated cameras become a scene folder."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from thermo.app._aligned import check_alignment, on_time, write_surface
from thermo.app._brought import cloud_of, to_points, to_silhouettes, with_scale
from thermo.app._cameras import cameras_of
from thermo.app._configuration import number
from thermo.app._recorded import files_of, frames_of, radiometry_of, stated_of
from thermo.app._register_doubts import order_words, place_words, replaced_words, stood_before
from thermo.app._stated_scene import check_room, compare_start, run_of, stated_scene
from thermo.imaging import (
    Camera,
    Looks,
    coverage,
    looks_of,
    place_samples,
    register_frames,
)
from thermo.mesh import Surface
from thermo.observe import Recording, Scene, check_number, write_scene, write_whole
from thermo.report import require_writable, write_registration


def register(settings: Mapping[str, Any]) -> None:
    """Bring frames to a surface, and leave a scene folder and how each sample was read."""
    out = Path(settings["out"])
    views = cameras_of(settings)
    scene, surface = stated_scene(settings)
    check_room(settings)
    check_alignment(settings)
    cloud = cloud_of(settings, surface)
    radiometry = radiometry_of(settings)
    stated, mend = stated_of(settings)
    together = check_number(
        settings["together"], where="together", quantity="time between frames [s]", least=0.0,
        remedy="give seconds, less than the time between two frames of a camera",
    )  # fmt: skip
    count = number(settings["samples"], "count", "samples.", whole=True, above=0)
    files = files_of(settings, views)
    cameras = [view.camera for view in views]
    brought = None
    if cloud is not None:
        brought = to_points(settings, surface, cloud)
        scene, surface = with_scale(settings, scene, brought), brought.surface
    looks = _looks(settings, surface, cameras)
    print(f"reading {len(files)} recordings", file=sys.stderr)
    read = [
        frames_of(settings, stated, mend, radiometry, *one)
        for one in zip(files, views, strict=True)
    ]
    frames = [one for one, _ in read]
    told = [
        f"{file}: {word}" for file, (_, words) in zip(files, read, strict=True) for word in words
    ]
    # What a script would else read past stands last.
    doubts = order_words(looks, frames, files)
    if settings["align"] is not None and brought is None:
        brought = to_silhouettes(settings, surface, cameras, frames, files)
        scene = with_scale(settings, scene, brought)
        looks = _looks(settings, brought.surface, cameras)
    told += place_words(looks, frames) if brought is None else brought.words
    samples = place_samples(looks, count=count)
    if settings["find_lamp_time"]:
        frames, words = on_time(settings, samples, cameras, frames)
        told += words
    where = str(settings["frames"] or settings["cameras"])
    recording = register_frames(samples, cameras, frames, together=together, where=where)
    run = run_of(settings, recording)
    told += compare_start(run)
    scene = replace(scene, runs=scene.runs | {run.name: run})
    before = None if settings["scene"] is not None else stood_before(out)
    _write(out, scene, brought and brought.surface)
    told += [*replaced_words(out, before), *doubts]
    record = write_registration(
        out, run.name, cameras, samples, coverage(looks), told, settings,
        alignment=brought and brought.found,
    )  # fmt: skip
    print(_table(recording, record, out))


def _looks(settings: Mapping[str, Any], surface: Surface, cameras: Sequence[Camera]) -> Looks:
    picked = settings["samples"]
    return looks_of(
        surface, cameras, grazing=number(picked, "grazing", "samples."),
        margin=number(picked, "margin", "samples.", whole=True, above=-1),
        where=str(settings["cameras"]),
    )  # fmt: skip


def _write(out: Path, scene: Scene, moved: Surface | None) -> None:
    """Write the scene, with the surface [m] where it was moved."""
    stood = scene.folder
    with tempfile.TemporaryDirectory() as folder:
        if moved is not None:
            path = Path(folder) / "surface.ply"
            write_surface(moved, path)
            scene = replace(scene, surface_path=path, unit="m")
        require_writable(out)
        write_scene(out, scene)
    _bring_along(stood, out, scene.runs)


def _bring_along(stood: Path, out: Path, runs: Iterable[str]) -> None:
    """Copy how the runs of a scene that stood were read: the scene itself does not hold it."""
    if stood.resolve() == out.resolve():
        return
    for name in runs:
        for ending in ("samples.npz", "registration.json"):
            file = stood / f"{name}+{ending}"
            if file.is_file():
                with write_whole(out / file.name) as temporary:
                    shutil.copyfile(file, temporary)


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

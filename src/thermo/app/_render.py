"""`thermo render`: pictures and films of a run."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from thermo import inverse
from thermo.app._cameras import cameras_of
from thermo.app._configuration import names, number
from thermo.discover import load_effects
from thermo.errors import InputError, meant
from thermo.imaging import (
    Colours,
    Degrees,
    coloured,
    interpolated,
    look_all,
    refined,
    render,
    sample_weights,
    with_bar,
    write_film,
    write_picture,
)
from thermo.mesh import Surface, read_surface
from thermo.observe import Recording, Run, Scene, read_scene
from thermo.report import Progress, figure_rendering, require_writable, say_to

FORMATS = ("npz", "gif", "mp4")
# Edges of the triangles that carry a picture, at least, along the diagonal of the object. What
# varies in waves of length L is drawn to (2 pi h / L)^2 / 8 of its height between vertices h apart:
# to 0.6 % for half a diagonal, to 3 % for a fifth.
EDGES = 60
DEGREES = {"K": Degrees.KELVIN, "C": Degrees.CELSIUS}


def render_run(settings: Mapping[str, Any]) -> None:
    """Render a run, and leave films, pictures and how they come about for each camera."""
    out = Path(settings["out"])
    formats, degrees = _formats(settings), _degrees(settings)
    nearest = number(settings, "nearest", whole=True, above=0)
    every = number(settings, "every", whole=True, above=0)
    rate = number(settings, "rate", above=0.0)
    scene = read_scene(Path(settings["data"]))
    run = _run_of(scene, str(settings["run"]))
    plain = read_surface(scene.surface_path, unit=scene.unit)
    surface = refined(plain, plain.diagonal() / EDGES)
    views = cameras_of(settings)
    maps = look_all(surface, [view.camera for view in views], where=str(settings["cameras"]))
    if settings["estimate"] is None:
        _check_nearest(nearest, run)
    require_writable(out)
    if settings["estimate"] is None:
        weights = sample_weights(run.recording.points, surface.vertices, k=nearest)
        time = run.recording.time[::every]
        values = interpolated(weights, run.recording.temperature[::every])
    else:
        time, values = _simulated(settings, scene, run, surface, every)
    colours = Colours(
        *_range(settings, values), name=str(settings["colours"]), background=(255, 255, 255)
    )
    for view, pixel_map in zip(views, maps, strict=True):
        stem = f"{run.name}_{view.camera.name}"
        with Progress(f"render {stem}", len(time), sys.stderr) as progress:
            write_film(
                [out / f"{stem}.{ending}" for ending in formats], pixel_map, time, values,
                colours=colours, degrees=degrees, rate=rate,
                on_frames=lambda done, total, shown=progress: shown.update(done, total=total),
            )  # fmt: skip
        last = render(pixel_map, values[-1])
        write_picture(out / f"{stem}.png", with_bar(coloured(last, colours), colours, degrees))
        if settings["estimate"] is None:
            figure_rendering(
                out / f"{stem}_steps.png", view.camera, surface, run.recording.points,
                run.recording.temperature[-1], k=nearest,
            )  # fmt: skip
        shown = ", ".join(f"{stem}.{ending}" for ending in (*formats, "png"))
        print(f"{out}: {shown}")


def _simulated(
    settings: Mapping[str, Any], scene: Scene, run: Run, surface: Surface, every: int
) -> tuple[np.ndarray, np.ndarray]:
    """Times (frames,) [s] and simulated temperatures of the vertices (frames, vertices) [K]."""
    time = run.recording.time[::every]
    # A recording at the vertices: what is measured there is not looked at.
    blank = np.full((len(time), len(surface.vertices)), run.initial_temperature)
    at_vertices = replace(run, recording=Recording(surface.vertices, time, blank))
    folder = Path(settings["estimate"])
    effects = load_effects(folder, scene) if (folder / "estimate.npz").exists() else None
    made = inverse.predict(
        replace(scene, runs={run.name: at_vertices}), folder, runs=(run.name,),
        tolerance=number(settings, "tolerance", above=0.0), additions=effects,
        say=say_to(sys.stderr),
    )[run.name]  # fmt: skip
    return made.time, made.temperature


def _run_of(scene: Scene, name: str) -> Run:
    if name not in scene.runs:
        raise InputError(
            "unknown run", where=f"{scene.folder}: runs", value=name, limit=", ".join(scene.runs),
            remedy=f"{meant(name, scene.runs)}name a run of the scene, as run=a",
        )  # fmt: skip
    return scene.runs[name]


def _check_nearest(nearest: int, run: Run) -> None:
    count = len(run.recording.points)
    if nearest > count:
        raise InputError(
            "there are no so many samples", where="nearest", value=nearest,
            limit=f"1 to {count}, the samples of run {run.name}", remedy="give fewer",
        )  # fmt: skip


def _range(settings: Mapping[str, Any], values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    lowest = low if settings["lowest"] is None else number(settings, "lowest")
    highest = high if settings["highest"] is None else number(settings, "highest")
    # A body as warm all over and all the time has no range of its own.
    return lowest, highest if highest > lowest or settings["highest"] is not None else lowest + 1.0


def _formats(settings: Mapping[str, Any]) -> tuple[str, ...]:
    formats = names(settings["formats"], "formats") or ()
    if not formats or set(formats) - set(FORMATS):
        raise InputError(
            "there is no such film", where="formats", value=list(formats),
            limit=", ".join(FORMATS), remedy="give formats=[npz,gif]",
        )  # fmt: skip
    return formats


def _degrees(settings: Mapping[str, Any]) -> Degrees:
    if settings["degrees"] not in DEGREES:
        raise InputError(
            "there are no such degrees", where="degrees", value=settings["degrees"],
            limit=" or ".join(DEGREES), remedy="give degrees=C",
        )  # fmt: skip
    return DEGREES[settings["degrees"]]

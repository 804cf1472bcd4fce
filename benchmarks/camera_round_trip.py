"""From a simulated body to frames of three cameras and back: temperatures and the conductivity.

    python benchmarks/camera_round_trip.py SCENES [bunny car] [--out FOLDER]

SCENES holds scenes that were simulated apart from this project. The stated truth is simulated on a
mesh of up to 40 000 nodes, which no fit uses, and read on triangles of a pixel's size; three
cameras of 320 x 240 pixels around the object see it with 0.05 K of noise in every pixel, ten frames
before the lamp and 121 after. `thermo register` makes a scene of their files. Then

- the frames are read at the places of the recording that the other solver made, where cameras see
  them, and compared with it: noise, what pixels and triangles interpolate, and what the two solvers
  differ by, all together;
- `thermo invert` fits the conductivity to the registered samples.

Leaves benchmarks/results/camera_round_trip.csv where all objects are asked for, and prints it.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from thermo.imaging import (
    Camera,
    Frames,
    View,
    look,
    looking_at,
    looks_of,
    refined,
    register_frames,
    render,
    samples_at,
    write_transforms,
)
from thermo.inverse import Meshing, simulate
from thermo.mesh import Surface, read_surface
from thermo.observe import Recording, Scene, read_scene

TABLE = Path(__file__).parent / "results" / "camera_round_trip.csv"
HEADER = [
    "object", "samples seen", "rms [K]", "noise left [K]", "rms without noise [K]",
    "conductivity [W/m/K]", "truth [W/m/K]", "off [%]",
]  # fmt: skip
NOISE = 0.05  # K, of a pixel
NODES = 40000  # of the mesh that is taken for the truth, at the most
EDGES = 120  # of the triangles that carry pictures, along the object's diagonal
QUIET = 10  # frames before the lamp
EVERY = 5  # frames of the recording for one of the cameras'
SIZE = (320, 240)  # px
AROUND = ((1.0, 0.5, 0.9), (-1.0, 0.6, 0.5), (0.2, 0.9, -1.0))  # where cameras stand


def main() -> None:
    """Run what is missing, print all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("objects", nargs="*")
    parser.add_argument("--out", type=Path, default=Path("outputs/camera_round_trip"))
    asked = parser.parse_args()
    rows = []
    for name in asked.objects or ("bunny", "car"):
        rows.append(row_of(asked.scenes / name, asked.out / name))
        print(", ".join(str(one) for one in rows[-1]), flush=True)
    if not asked.objects:
        with TABLE.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])


def cameras_about(surface: Surface) -> list[Camera]:
    """Three cameras, the object four fifths as high as their frames."""
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    middle, diagonal = (low + high) / 2, surface.diagonal()
    made = []
    for number, way in enumerate(AROUND):
        place = middle + 3.0 * diagonal * np.array(way) / np.linalg.norm(way)
        pose = looking_at(place, middle, np.array([0.0, 1.0, 0.0]))
        centre = [(edge - 1) / 2 for edge in SIZE]
        focal = 0.8 * SIZE[1] * 3.0
        made.append(Camera(*SIZE, (focal, focal), centre, pose, name=f"camera_{number}"))
    return made


def truth_at(scene: Scene, surface: Surface, out: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and the simulated temperatures of all vertices [K]."""
    file = out / "truth.npz"
    if not file.exists():
        run = scene.runs["heating"]
        time = run.recording.time[::EVERY]
        blank = np.full((len(time), len(surface.vertices)), run.initial_temperature)
        at_vertices = replace(run, recording=Recording(surface.vertices, time, blank))
        stated = json.loads((scene.folder / "scene.json").read_text("utf-8"))["truth"]
        made = simulate(
            replace(scene, runs={"heating": at_vertices}), "heating",
            values={"conductivity": stated["conductivity"]}, tolerance=2e-3,
            meshing=Meshing(max_nodes=NODES),
        )  # fmt: skip
        np.savez(file, time=made.time, temperature=made.temperature)
    with np.load(file) as held:
        return held["time"], held["temperature"]


def filmed(
    camera: Camera, surface: Surface, time: np.ndarray, vertices: np.ndarray, noise: float
) -> Frames:
    """What a camera records: the object in a room as warm as it was at first."""
    random = np.random.default_rng(int(camera.name[-1]))
    before = np.arange(-QUIET, 0) * float(np.median(np.diff(time)))
    whole = np.concatenate([np.repeat(vertices[:1], QUIET, 0), vertices])
    seen = look(camera, surface)
    frames = np.stack([render(seen, one) for one in whole])
    frames = np.where(np.isnan(frames), vertices[0, 0], frames)
    frames += noise * random.standard_normal(frames.shape)
    return Frames(np.concatenate([before, time]), frames.astype(np.float32))


def row_of(folder: Path, out: Path) -> list[object]:
    """Temperatures and conductivity of one object."""
    out.mkdir(parents=True, exist_ok=True)
    scene = read_scene(folder)
    plain = read_surface(scene.surface_path, unit=scene.unit)
    surface = refined(plain, plain.diagonal() / EDGES)
    time, vertices = truth_at(scene, surface, out)
    cameras = cameras_about(surface)
    films = [filmed(one, surface, time, vertices, NOISE) for one in cameras]
    clean = [filmed(one, surface, time, vertices, 0.0) for one in cameras]
    measured = scene.runs["heating"].recording
    places = samples_at(looks_of(plain, cameras), measured.points)
    seen = places.seen.any(axis=0)
    other = measured.temperature[::EVERY][:, seen]
    read, plain = (
        register_frames(places, cameras, one).temperature[:, seen] for one in (films, clean)
    )
    rms = [float(np.sqrt(np.mean(off**2))) for off in (read - other, read - plain, plain - other)]
    found, truth = fitted(scene, cameras, films, out)
    off = 100 * (found / truth - 1)
    return [folder.name, int(seen.sum()), *(f"{one:.4f}" for one in rms), f"{found:.4g}", truth,
            f"{off:.2f}"]  # fmt: skip


def fitted(
    scene: Scene, cameras: list[Camera], films: list[Frames], out: Path
) -> tuple[float, float]:
    """The conductivity [W/m/K] that the commands find, and the stated one."""
    files = [f"{one.name}.npz" for one in cameras]
    for file, film in zip(files, films, strict=True):
        np.savez(out / file, time=film.time, frames=film.values)
    write_transforms(
        out / "transforms.json", [View(*one) for one in zip(cameras, files, strict=True)]
    )
    run = scene.runs["heating"]
    lamp = run.heater
    assert lamp is not None
    heater = (
        f"{{centre:{lamp.centre.tolist()},direction:{lamp.direction.tolist()},"
        f"radius:{float(lamp.radius)},power:{float(lamp.power)},until:{float(lamp.until)}}}"
    )
    words = [
        "register", f"frames=[{','.join(str(out / one) for one in files)}]",
        f"cameras={out / 'transforms.json'}", f"surface={scene.surface_path}", f"unit={scene.unit}",
        f"out={out / 'scene'}", "run=heating", f"material.density={scene.material.density}",
        f"material.heat_capacity={scene.material.heat_capacity}",
        f"surface_exchange.convection={scene.convection}",
        f"surface_exchange.emissivity={scene.emissivity}",
        f"ambient_temperature={run.ambient_temperature}", f"heater={heater}",
    ]  # fmt: skip
    subprocess.run([sys.executable, "-m", "thermo", *words], check=True)
    words = ["invert", f"data={out / 'scene'}", "field=uniform", f"out={out / 'invert'}"]
    subprocess.run([sys.executable, "-m", "thermo", *words], check=True)
    record = json.loads((out / "invert" / "result.json").read_text("utf-8"))
    stated = json.loads((scene.folder / "scene.json").read_text("utf-8"))["truth"]
    return record["fields"]["conductivity"]["median"], float(stated["conductivity"])


if __name__ == "__main__":
    main()

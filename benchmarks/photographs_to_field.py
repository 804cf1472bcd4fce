"""From photographs to a conductivity: rebuild the surface, heat it, fit, predict; as a user would.

    python benchmarks/photographs_to_field.py [--objects bunny,bear] [--data FOLDER] [--out FOLDER]

Each object is photographed by `photographed.py`, 32 pictures of 128 x 128 pixels. Their cameras
stand in a unit that nobody states; distances between 40 pairs of cameras are measured to 5 %, and
one in ten of these is wrong. Then

1. `thermo reconstruct` makes the surface in metres and says how well its scale is known;
2. scenes are made of that surface and of the object's recordings, which were made on the true one
   by another program and whose samples therefore do not lie on the rebuilt one: `measured` has the
   surface as it was left, `known` the same one in the true unit, as `camera_scale` would give it;
3. `thermo invert` fits the conductivity to `heating`, from three times the true one, on either
   and, to compare, on the `true` surface;
4. `thermo predict` predicts the two runs that were held out.

`results/photographs_to_field.csv` holds the errors. The truth is read only to say where the fit
starts and how far off it ends. Seconds are those of the commands, start and compilation included.
A surface or a fit that an earlier run left in --out is not made again.

The scenes are not in the repository: --data, or the environment variable THERMOFIELD_DATA, names
the folder that holds `scenes`; `data` in the repository's root otherwise.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import trimesh
from photographed import photographs_of, surface_error, write_photographs

import thermo
from thermo.imaging import read_cameras
from thermo.observe import write_scene

ROOT: Final = Path(__file__).resolve().parents[1]
RESULTS: Final = ROOT / "benchmarks" / "results" / "photographs_to_field.csv"
UNIT: Final = 0.137
"""Length of the cameras' unit [m], which no command is told."""
PAIRS: Final = 40
NOISE: Final = 0.05
"""Relative deviation of a measured distance [1]."""
WRONG: Final = 0.1
"""Share of distances that are wrong by a factor from a half to two [1]."""
FACTOR: Final = 3.0
"""Where a fit starts over the truth [1]."""
HEADER: Final = ("object", "surface", "distance_percent", "scale_error_percent",
                 "scale_deviation_percent", "error_percent", "deviation_percent", "rmse_K",
                 "warming_mae_K", "heating_mae_K", "reconstruct_seconds",
                 "invert_seconds")  # fmt: skip


def photograph_scene(scene: thermo.Scene, folder: Path, seed: int) -> None:
    """Leave photographs, cameras in another unit, and measured distances of cameras [m]."""
    mesh = trimesh.load_mesh(scene.surface_path)
    mesh.apply_scale(1 / UNIT)
    write_photographs(folder, photographs_of(mesh).photographs)
    views = read_cameras(folder / "transforms.json")
    random = np.random.default_rng(seed)
    lines = ["# camera camera metres"]
    for number in range(PAIRS):
        one, other = random.choice(len(views), 2, replace=False)
        apart = UNIT * np.linalg.norm(views[one].camera.place() - views[other].camera.place())
        apart *= np.exp(NOISE * random.normal())
        if number < WRONG * PAIRS:
            apart *= 2 ** random.uniform(-1, 1)
        lines.append(f"{views[one].file} {views[other].file} {apart:.6f}")
    (folder / "distances.txt").write_text("\n".join(lines) + "\n")


def command(*words: str) -> None:
    """Run a verb of thermo, as typed."""
    print("thermo", *words, flush=True)
    subprocess.run([Path(sys.executable).with_name("thermo"), *words], check=True)


def rebuilt_scene(scene: thermo.Scene, part: Path, folder: Path, *, known: bool) -> dict[str, Any]:
    """A scene of the rebuilt surface and the recordings; what is to be told of that surface."""
    record = json.loads((part / "result.json").read_text())
    mesh = trimesh.load_mesh(part / record["surface"]["file"])
    off, deviation = record["scale"]["factor"] / UNIT - 1, record["scale"]["relative_deviation"]
    if known:
        mesh.apply_scale(1 / (1 + off))
        off = deviation = 0.0
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "rebuilt.ply"
    mesh.export(path)
    write_scene(
        folder / "scene", replace(scene, surface_path=path, unit="m", scale_deviation=deviation)
    )
    return {
        "distance_percent": 100 * surface_error(mesh, trimesh.load_mesh(scene.surface_path)).share,
        "scale_error_percent": 100 * off,
        "scale_deviation_percent": 100 * deviation,
        "reconstruct_seconds": record["seconds"],
    }


def fit(folder: Path, truth: float, out: Path) -> dict[str, Any]:
    """Fit the conductivity of a scene and predict what was held out."""
    result = out / "invert" / "result.json"
    if not result.is_file():
        command(
            "invert", f"data={folder}", "runs=[heating]", "unknown=[conductivity]",
            f"initial.conductivity={FACTOR * truth:.6g}", f"out={result.parent}",
        )  # fmt: skip
    if not (out / "predict" / "result.json").is_file():
        command(
            "predict", f"data={folder}", f"estimate={result.parent}",
            "runs=[test_warming,test_heating]", f"out={out / 'predict'}",
        )  # fmt: skip
    found = json.loads(result.read_text())
    scores = json.loads((out / "predict" / "result.json").read_text())["scores"]
    left = (found.get("scale") or {}).get("deviation_with", {}).get("conductivity")
    return {
        "error_percent": 100 * (found["fields"]["conductivity"]["median"] / truth - 1),
        "deviation_percent": None if left is None else 100 * left,
        "rmse_K": found["fit"]["rmse"]["heating"],
        "warming_mae_K": scores["test_warming"]["spatial"]["mae"],
        "heating_mae_K": scores["test_heating"]["spatial"]["mae"],
        "invert_seconds": found["seconds"],
    }


def study(source: Path, out: Path, seed: int) -> Iterator[dict[str, Any]]:
    """The lines of the rebuilt surface, in either unit, and that of the true one."""
    scene, photos, part = thermo.read_scene(source), out / "photographs", out / "part"
    truth = float(json.loads((source / "scene.json").read_text())["truth"]["conductivity"])
    if not (part / "result.json").is_file():
        photograph_scene(scene, photos, seed)
        command(
            "reconstruct", f"cameras={photos / 'transforms.json'}",
            f"scale.cameras={photos / 'distances.txt'}", f"out={part}",
        )  # fmt: skip
    for name in ("known", "measured"):
        line = rebuilt_scene(scene, part, out / name, known=name == "known")
        line |= fit(out / name / "scene", truth, out / name)
        yield {"object": scene.object, "surface": name} | line
    yield {"object": scene.object, "surface": "true"} | fit(source, truth, out / "true")


def write_table(rows: list[dict[str, Any]]) -> None:
    """Write the lines; others that stand in the table stay."""
    made = {(row["object"], row["surface"]) for row in rows}
    stay = []
    if RESULTS.is_file():
        with RESULTS.open(newline="") as stream:
            stay = [
                row for row in csv.DictReader(stream) if (row["object"], row["surface"]) not in made
            ]
    with RESULTS.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, HEADER, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(stay)
        writer.writerows(
            {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows
        )


def main() -> None:
    """Run the objects that are asked for."""
    parser = argparse.ArgumentParser(description="From photographs to a conductivity.")
    parser.add_argument("--data", type=Path, help="folder that holds scenes")
    parser.add_argument("--objects", default="bunny")
    parser.add_argument("--out", type=Path, default=ROOT / "outputs" / "photographs_to_field")
    given = parser.parse_args()
    data = given.data or Path(os.environ.get("THERMOFIELD_DATA", ROOT / "data"))
    if not (data / "scenes").is_dir():
        sys.exit(f"no scenes in {data}: give --data FOLDER or set THERMOFIELD_DATA")
    rows = []
    for seed, name in enumerate(given.objects.split(",")):
        for row in study(data / "scenes" / name, given.out / name, seed):
            rows.append(row)
            write_table(rows)
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()

"""Uniform conductivity of six objects from one run each, and what it predicts.

    python benchmarks/six_objects.py [--objects bunny,cube] [--factor 3] [--table FILE]

For every object a Levenberg-Marquardt fit of one conductivity to `heating`, and one to `cooling`,
each from a factor off the truth; then predictions of the held-out `test_warming` and
`test_heating` with the value that `heating` gave. The cylinder's convection coefficient is
fitted to its cooling with that conductivity. The recordings come from another program on finer
meshes; the truth is read only here, to say where to start and how far off the answer is. Seconds
are those of `thermo.invert` with the mesh in its cache, compilation included.

The objects are not in the repository: --data, or the environment variable THERMOFIELD_DATA, names
the folder that holds `scenes`; `data` in the repository's root otherwise.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import sys
import time
from pathlib import Path

import thermo
from thermo.inverse import Estimate, Meshing, Uniform, summary
from thermo.mesh import promote
from thermo.observe import Scene

ROOT = Path(__file__).resolve().parents[1]
OBJECTS = ("bunny", "car", "sphere", "cylinder", "cube", "bear")
HEADER = ("object", "unknown", "run", "nodes", "error_percent", "iterations", "seconds", "rmse_K",
          "warming_mae_K", "heating_mae_K", "predict_seconds")  # fmt: skip


def median(estimate: Estimate, name: str) -> float:
    """Median [SI] of a recovered field over the surface."""
    return float(summary(estimate.mesh, estimate.fields[name])["median"])


def fit(
    scene: Scene, run: str, name: str, initial: dict[str, float], cache: Path
) -> tuple[Estimate, float]:
    """A fit of one value, and how long it took with its mesh in the cache [s]."""
    while True:
        before = set(cache.glob("*"))
        begun = time.monotonic()
        estimate = thermo.invert(
            scene,
            runs=(run,),
            unknown=(name,),
            choice=Uniform(),
            initial=initial,
            meshing=Meshing(cache=cache),
        )
        seconds = time.monotonic() - begun
        if before and set(cache.glob("*")) == before:
            return estimate, seconds


def row(scene: Scene, run: str, name: str, truth: float, fitted: tuple[Estimate, float]) -> dict:
    """A line of the table."""
    estimate, seconds = fitted
    return {
        "object": scene.object,
        "unknown": name,
        "run": run,
        "nodes": len(promote(estimate.mesh).nodes),
        "error_percent": 100 * (median(estimate, name) / truth - 1),
        "iterations": sum(len(losses) - 1 for losses in estimate.history),
        "seconds": seconds,
        "rmse_K": estimate.runs[run].rmse,
    }


def study(folder: Path, factor: float, cache: Path) -> list[dict]:
    """All fits and predictions of one object."""
    truth = float(json.loads((folder / "scene.json").read_text())["truth"]["conductivity"])
    scene = thermo.read_scene(folder)
    rows, found = [], truth
    for run in ("heating", "cooling"):
        start = {"conductivity": factor * truth}
        fitted = fit(scene, run, "conductivity", start, cache)
        line = row(scene, run, "conductivity", truth, fitted)
        if run == "heating":
            found = median(fitted[0], "conductivity")
            begun = time.monotonic()
            made = thermo.predict(scene, fitted[0])
            line["predict_seconds"] = time.monotonic() - begun
            for name in ("warming", "heating"):
                line[f"{name}_mae_K"] = made[f"test_{name}"].scores["spatial"].mae
        rows.append(line)
        show(line)
    if scene.object == "cylinder":
        stated = scene.convection
        start = {"conductivity": found, "convection": factor * stated}
        fitted = fit(scene, "cooling", "convection", start, cache)
        rows.append(row(scene, "cooling", "convection", stated, fitted))
        show(rows[-1])
    return rows


def show(line: dict) -> None:
    """Print a line as soon as it is known."""
    cells = [f"{v:.3g}" if isinstance(v, float) else str(v) for v in line.values()]
    print("  ".join(f"{name}={cell}" for name, cell in zip(line, cells, strict=True)), flush=True)


def write_table(path: Path, rows: list[dict]) -> None:
    """Write what is known so far: the whole takes half an hour."""
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, HEADER)
        writer.writeheader()
        writer.writerows(
            {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in line.items()} for line in rows
        )


def main() -> None:
    """Run the objects that are asked for."""
    parser = argparse.ArgumentParser(description="Uniform conductivity of six objects.")
    parser.add_argument("--data", type=Path, help="folder that holds scenes")
    parser.add_argument("--objects", default=",".join(OBJECTS))
    parser.add_argument("--factor", type=float, default=3.0, help="start over truth")
    parser.add_argument("--cache", type=Path, default=ROOT / "outputs" / "meshes")
    parser.add_argument("--table", type=Path, help="CSV file for the results")
    given = parser.parse_args()
    data = given.data or Path(os.environ.get("THERMOFIELD_DATA", ROOT / "data"))
    if not (data / "scenes").is_dir():
        sys.exit(f"no scenes in {data}: give --data FOLDER or set THERMOFIELD_DATA")
    given.cache.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in given.objects.split(","):
        rows += study(data / "scenes" / name, given.factor, given.cache)
        if given.table:
            write_table(given.table, rows)


if __name__ == "__main__":
    main()

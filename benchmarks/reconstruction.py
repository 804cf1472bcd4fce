"""Surfaces rebuilt from photographs: how far off they are, and what photographs say of them.

    python benchmarks/reconstruction.py [--objects bunny,dino] [--training fast] [--data FOLDER]

Bunny, bear and bracket are photographed by `photographed.py` and rebuilt from 32 pictures of
128 x 128 pixels with masks. `results/reconstruction.csv` holds the mean symmetric distance from the
true surface over the diagonal of its box, the volume over the true one, and the PSNR of four views
that were left out.

Dino and temple are real, 16 photographs each (Seitz et al., CVPR 2006); masks come from the
threshold that is found, with gaps closed, and the region to look in from the published box. Their
true surfaces are not public.
`results/reconstruction_silhouettes.csv` holds the overlap of the surface's silhouette with each
mask, whether the surface is closed, and how far it reaches beyond the published box, and
`docs/images` six views of each.

`--training full` trains as `thermo reconstruct training=full` does, which is meant for a GPU.

Seconds are those of the training and of the surface, compilation included. An object that is run
takes the place of its lines with the same training in the tables; all others stay.

The objects are not in the repository: --data, or the environment variable THERMOFIELD_DATA, names
the folder that holds `geometry` and `multiview`; `data` in the repository's root otherwise.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

import jax
import numpy as np
import trimesh
from omegaconf import OmegaConf
from photographed import (
    FILES,
    data_folder,
    photographed,
    silhouette_iou,
    surface_error,
)

from thermo.app._training import build_training
from thermo.imaging import read_cameras
from thermo.reconstruct import (
    Photograph,
    Region,
    Trained,
    Training,
    masked_by_threshold,
    picture,
    psnr,
    read_photographs,
    reconstruct,
    region_of,
    threshold_of,
)
from thermo.report import figure_turntable, upward

ROOT: Final = Path(__file__).resolve().parents[1]
RESULTS: Final = ROOT / "benchmarks" / "results"
IMAGES: Final = ROOT / "docs" / "images"
TRAININGS: Final = ("fast", "full")
REAL: Final = {"dino": "middlebury_dinoSparseRing", "temple": "middlebury_templeSparseRing"}
BRIDGED: Final = 10
"""By how much masks are grown and then shrunk [px], to close shadows: their authors grow by it."""


class Rebuilt(NamedTuple):
    """A rebuilt surface [m], what it was taken from, and how long it took [s]."""

    surface: trimesh.Trimesh
    trained: Trained
    seconds: float


def training_of(name: str) -> Training:
    """The training that `thermo reconstruct training=NAME` has."""
    settings = OmegaConf.to_container(OmegaConf.load(ROOT / "conf" / "training" / f"{name}.yaml"))
    return build_training(cast(dict[str, Any], settings), seed=0)


def rebuild(photographs: Sequence[Photograph], region: Region, training: str) -> Rebuilt:
    """A surface: the one place that knows how it is called."""
    begun = time.monotonic()
    found = reconstruct(photographs, region, training_of(training), on_step=_told)
    seconds = time.monotonic() - begun
    surface = trimesh.Trimesh(found.surface.vertices, found.surface.triangles, process=False)
    return Rebuilt(surface, found.trained, seconds)


def rendered(name: str, data: Path, training: str) -> list[dict[str, Any]]:
    """One line of the first table."""
    made = photographed(name, data)
    found = rebuild(made.photographs, region_of(made.photographs), training)
    error = surface_error(found.surface, made.truth)
    decibels = [psnr(picture(found.trained, one.camera), one) for one in made.left_out]
    line = {
        "object": name,
        "training": training,
        "distance_percent": 100 * error.share,
        "volume_ratio": error.volume,
        "closed": found.surface.is_watertight,
        "triangles": len(found.surface.faces),
        "left_out_psnr_dB": float(np.mean(decibels)),
        "left_out_psnr_least_dB": min(decibels),
        "seconds": round(found.seconds),
        "on": _processor(),
    }
    return [line]


def real(name: str, data: Path, training: str) -> list[dict[str, Any]]:
    """Lines of the second table, one a photograph."""
    folder = data / "multiview" / REAL[name]
    photographs = real_photographs(name, folder)
    box = published_box(folder)
    found = rebuild(photographs, region_of(photographs, box), training)
    beyond = reach_beyond(found.surface, box)
    # The pictures are those of what README and docs tell of, two cores.
    if training == "fast":
        figure_turntable(IMAGES / f"reconstruct_{name}.png", found.trained, upward(photographs))
    return [
        {
            "object": name,
            "training": training,
            "photograph": one.file,
            "iou": silhouette_iou(found.surface, one),
            "closed": found.surface.is_watertight,
            "beyond_box_mm": 1e3 * beyond,
            "seconds": round(found.seconds),
            "on": _processor(),
        }
        for one in photographs
    ]


def real_photographs(name: str, folder: Path) -> tuple[Photograph, ...]:
    """Photographs of `dino` or `temple`, with masks."""
    views = read_cameras(next(folder.glob("*_par.txt")))
    plain = read_photographs(views, folder)
    return masked_by_threshold(plain, threshold_of(plain), bridged=BRIDGED)


def published_box(folder: Path) -> np.ndarray:
    """Least and largest coordinates [m], (2, 3), as the data's own description states them."""
    text = (folder / "origin_README.txt").read_text("utf-8")
    return np.array(re.findall(r"^\((\S+) (\S+) (\S+)\)\s*$", text, re.MULTILINE), float)


def reach_beyond(surface: trimesh.Trimesh, box: np.ndarray) -> float:
    """How far a surface reaches out of a box [m]; not above 0 where it lies inside."""
    return float(max((box[0] - surface.bounds[0]).max(), (surface.bounds[1] - box[1]).max()))


def keep(table: Path, lines: list[dict[str, Any]]) -> None:
    """Write lines into a table in place of those of the same object and training."""
    rows = [{k: f"{v:.4g}" if isinstance(v, float) else v for k, v in one.items()} for one in lines]
    for row in rows:
        print("  ".join(f"{key}={value}" for key, value in row.items()), flush=True)
    new = {(row["object"], row["training"]) for row in rows}
    if table.exists():
        with table.open(newline="") as stream:
            old = [r for r in csv.DictReader(stream) if (r["object"], r["training"]) not in new]
        rows = old + rows
    with table.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[-1]))
        writer.writeheader()
        writer.writerows(rows)


def _told(step: int, steps: int, decibels: float) -> None:
    if step % 500 == 0:
        print(f"step {step} of {steps}: {decibels:.1f} dB", flush=True)


def _processor() -> str:
    device, cores = jax.devices()[0], len(os.sched_getaffinity(0))
    return device.device_kind if device.platform != "cpu" else f"{cores} cores"


def main() -> None:
    """Rebuild each object, print its lines and write them down."""
    parser = argparse.ArgumentParser(description="Surfaces rebuilt from photographs.")
    parser.add_argument("--data", type=Path, help="folder that holds geometry and multiview")
    parser.add_argument("--objects", default=",".join([*FILES, *REAL]))
    parser.add_argument("--training", choices=TRAININGS, default="fast")
    given = parser.parse_args()
    data, names = data_folder(given.data), given.objects.split(",")
    for name in names:
        if name not in (*FILES, *REAL):
            parser.error(f"--objects {name}: known are {', '.join([*FILES, *REAL])}")
    for name in names:
        if name in FILES:
            keep(RESULTS / "reconstruction.csv", rendered(name, data, given.training))
        else:
            keep(RESULTS / "reconstruction_silhouettes.csv", real(name, data, given.training))


if __name__ == "__main__":
    main()

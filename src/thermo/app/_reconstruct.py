"""`thermo reconstruct`: photographs of calibrated cameras become a closed metric surface."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from thermo.app._cameras import cameras_of
from thermo.app._configuration import names, number
from thermo.app._metric_scale import scale_of, stated_scale
from thermo.app._training import build_training
from thermo.errors import InputError
from thermo.imaging import View
from thermo.mesh import Surface
from thermo.reconstruct import (
    Finding,
    Photograph,
    masked_by_threshold,
    preflight,
    read_photographs,
    reconstruct,
    region_of,
    threshold_of,
)
from thermo.report import Progress, require_writable, write_reconstruction


def reconstruct_surface(settings: Mapping[str, Any]) -> None:
    """Train on photographs, and leave `surface.ply`, `turntable.png` and `result.json`."""
    begun = time.monotonic()
    out = Path(settings["out"])
    training = build_training(settings["training"], number(settings, "seed", whole=True, above=-1))
    triangles = number(settings, "triangles", whole=True, above=99)
    views = cameras_of(settings)
    stated = stated_scale(settings, views)
    photographs, left_out = _photographs(settings, views)
    region = region_of(photographs, settings["box"])
    findings = preflight(photographs, region)
    _require_fit(findings)
    require_writable(out)
    checkpoint = out / "checkpoint.npz"
    start = f"going on from {checkpoint}" if checkpoint.exists() else "training"
    print(f"{start} on {len(photographs)} photographs; compiling comes first", file=sys.stderr)
    shown = Progress("reconstruct", training.steps, sys.stderr, measure="PSNR [dB]")
    with shown as progress:
        found = reconstruct(
            photographs, region, training, triangles=triangles, checkpoint=checkpoint,
            on_step=lambda step, most, decibels: progress.update(step, decibels, most),
        )  # fmt: skip
    scale = scale_of(stated, views, found.trained)
    factor = 1.0 if scale is None else scale.factor
    surface = Surface(factor * found.surface.vertices, found.surface.triangles)
    record = write_reconstruction(
        out, surface, found.trained, scale, photographs, left_out, findings,
        time.monotonic() - begun, settings,
    )  # fmt: skip
    checkpoint.unlink(missing_ok=True)
    print(_table(record, out))


def _photographs(
    settings: Mapping[str, Any], views: Sequence[View]
) -> tuple[tuple[Photograph, ...], tuple[Photograph, ...]]:
    """Those to train on and those left out, with the masks that are asked for."""
    cameras = Path(settings["cameras"])
    folder = Path(settings["images"] or (cameras if cameras.is_dir() else cameras.parent))
    masks, threshold = settings["masks"], settings["threshold"]
    bridged = number(settings, "bridged", whole=True, above=-1)
    if masks is not None and threshold is not None:
        raise InputError(
            "the object is told in two ways", where="threshold", value=threshold,
            limit=f"masks={masks} or a threshold", remedy="leave one of them out",
        )  # fmt: skip
    if bridged and threshold is None:
        raise InputError(
            "there is no threshold whose gaps could be closed", where="bridged", value=bridged,
            limit="0 without threshold", remedy="give threshold=auto",
        )  # fmt: skip
    left_out = names(settings["left_out"], "left_out") or ()
    print(f"reading {len(views)} photographs", file=sys.stderr)
    read = read_photographs(views, folder, masks=None if masks is None else Path(masks))
    if threshold is not None:
        level = threshold_of(read) if threshold == "auto" else number(settings, "threshold")
        print(f"brighter than {level:.3f} is the object", file=sys.stderr)
        read = masked_by_threshold(read, level, bridged=bridged)
    return _parted(read, left_out)


def _parted(
    photographs: Sequence[Photograph], left_out: Sequence[str]
) -> tuple[tuple[Photograph, ...], tuple[Photograph, ...]]:
    known = {name: one for one in photographs for name in (Path(one.file).name, one.file)}
    for name in left_out:
        if name not in known:
            raise InputError(
                "there is no such photograph", where="left_out", value=name,
                limit=", ".join(one.file for one in photographs),
                remedy="give names of pictures as the cameras' file has them",
            )  # fmt: skip
    kept_back = tuple(known[name] for name in dict.fromkeys(left_out))
    rest = tuple(one for one in photographs if not any(one is other for other in kept_back))
    return rest, kept_back


def _require_fit(findings: Sequence[Finding]) -> None:
    """Say what the checks found. Raises `InputError` for the first that training cannot mend."""
    for one in findings:
        if not one.fatal:
            print(f"{one.where}: {one.what}; {one.remedy}", file=sys.stderr)
    for one in findings:
        if one.fatal:
            raise InputError(
                one.what, where=one.where, value="found before training",
                limit="photographs that can be trained on", remedy=one.remedy,
            )  # fmt: skip


def _table(record: Mapping[str, Any], out: Path) -> str:
    """What a person reads at the end."""
    surface = record["surface"]
    low, high = (np.asarray(one) for one in surface["box"])
    size = " x ".join(f"{1e3 * side:.4g}" for side in high - low)
    rows = [f"{surface['triangles']} triangles, {size} mm, {1e6 * surface['volume']:.4g} cm3"]
    overlaps = [
        one["silhouette_overlap"] for one in record["photographs"].values()
        if one["silhouette_overlap"] is not None
    ]  # fmt: skip
    if overlaps:
        rows.append(f"silhouettes overlap by {min(overlaps):.3f} and more (1 is all)")
    for name, one in record["left_out"].items():
        rows.append(f"{name}, not trained on: PSNR {one['psnr']:.1f} dB")
    scale = record["scale"]
    if scale is not None:
        share = 100 * scale["relative_deviation"]
        rows.append(
            f"scale {scale['factor']:.5g} from {scale['source']}, one deviation {share:.2g} %: a "
            f"diffusivity from this surface is uncertain by {2 * share:.2g} % for that alone"
        )
    surface_file = out / surface["file"]
    return "\n".join([*rows, f"{surface_file}, {record['seconds']:.0f} s"])

"""What bringing frames to a surface leaves beside the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from thermo.imaging import Alignment, Camera, PointAlignment, SurfaceSamples

from ._json import write_json
from ._npz import write_npz
from ._versions import versions


def write_registration(
    folder: Path,
    run: str,
    cameras: Sequence[Camera],
    samples: SurfaceSamples,
    coverage: float,
    told: Sequence[str],
    configuration: Mapping[str, Any],
    *,
    alignment: Alignment | PointAlignment | None = None,
) -> dict[str, Any]:
    """Write how the samples of a run were read, and return that record.

    Leaves `RUN+samples.npz` (points [m], and a camera in each row: whether it sees a sample, the
    footprint of a pixel there [m], the cosine to the normal [1]) and `RUN+registration.json`. "+"
    cannot stand in a run's name, so that no recording is met.

    Arguments:

    - `folder`, `run`: where they are left, and the name they begin with.
    - `cameras`, `samples`: in one order; the record tells of each camera how many samples it reads
      and the median footprint of a pixel there [m], by its name.
    - `coverage`: share of the surface that cameras read [1].
    - `told`: what was wrong with the frames, in words. `configuration`: what was asked for.
    - `alignment`: how the surface was brought to the cameras, and how well that is known.
    """
    write_npz(
        folder / f"{run}+samples.npz", points=samples.points, seen=samples.seen,
        footprint=samples.footprint, cosine=samples.cosine,
    )  # fmt: skip
    record = {
        "format": "thermofield-registration/1",
        "run": run,
        "samples": len(samples.points),
        "coverage": coverage,
        "cameras": {
            camera.name: {
                "samples": int(seen.sum()),
                "footprint": float(np.median(side[seen])) if seen.any() else None,
                "footprint_unit": "m",
            }
            for camera, seen, side in zip(cameras, samples.seen, samples.footprint, strict=True)
        },
        "alignment": None if alignment is None else _alignment(alignment),
        "told": list(told),
        "versions": versions(),
        "configuration": configuration,
    }
    write_json(folder / f"{run}+registration.json", record)
    return record


def _alignment(found: Alignment | PointAlignment) -> dict[str, Any]:
    """The similarity x' = s R x + t, and one standard deviation of it."""
    moved, deviation = found.similarity, found.deviation
    seen = isinstance(found, Alignment)
    record = {
        "to": "silhouettes" if seen else "points",
        "rotation": moved.rotation.tolist(),
        "shift": moved.shift.tolist(),
        "shift_unit": "m",
        "scale": moved.scale,
        "rotation_deviation": deviation[:3].tolist(),
        "rotation_deviation_unit": "rad",
        "place_deviation": deviation[3:6].tolist(),
        "place_deviation_unit": "m",
        "scale_deviation": float(deviation[6]),
        "untold": list(found.untold),
        "residual": found.residual,
        "residual_unit": "px" if seen else "m",
    }
    if isinstance(found, Alignment):
        return record | {
            "overlap_before": found.overlap_before.tolist(),
            "overlap_after": found.overlap_after.tolist(),
        }
    return record | {"inliers": found.inliers}

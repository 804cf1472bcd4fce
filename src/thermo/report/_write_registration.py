"""What bringing frames to a surface leaves beside the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from thermo.imaging import Camera, SurfaceSamples

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
        "told": list(told),
        "versions": versions(),
        "configuration": configuration,
    }
    write_json(folder / f"{run}+registration.json", record)
    return record

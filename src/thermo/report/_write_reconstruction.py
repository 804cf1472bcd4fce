"""What a reconstruction leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from thermo.imaging import overlap, silhouette
from thermo.mesh import Surface
from thermo.observe import write_whole
from thermo.reconstruct import Finding, MetricScale, Photograph, Trained, picture, psnr

from ._figure_turntable import figure_turntable, upward
from ._json import write_json
from ._versions import versions


def write_reconstruction(
    folder: Path,
    surface: Surface,
    trained: Trained,
    scale: MetricScale | None,
    photographs: Sequence[Photograph],
    left_out: Sequence[Photograph],
    findings: Sequence[Finding],
    seconds: float,
    configuration: Mapping[str, Any],
) -> dict[str, Any]:
    """Write `surface.ply` [m], `turntable.png` and `result.json`, and return that record.

    Arguments:

    - `surface`: with its scale applied [m]. `trained`: in the cameras' own unit.
    - `scale`: how that unit became metres, None where the cameras' file said it.
    - `photographs`: trained on. `left_out`: others, to judge by.
    - `findings`: of the checks before. `seconds`: the whole took [s].
    - `configuration`: what was asked for.

    Raises `InputError` where a file cannot be written.
    """
    with write_whole(folder / "surface.ply") as temporary:
        mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
        mesh.export(temporary)
    figure_turntable(folder / "turntable.png", trained, upward(photographs))
    own = surface if scale is None else Surface(surface.vertices / scale.factor, surface.triangles)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    record = {
        "format": "thermofield-reconstruction/1",
        "verb": "reconstruct",
        "surface": {
            "file": "surface.ply",
            "unit": "m",
            "triangles": len(surface.triangles),
            "area": surface.area(),
            "area_unit": "m2",
            "volume": surface.volume(),
            "volume_unit": "m3",
            "box": [low.tolist(), high.tolist()],
        },
        "scale": None if scale is None else _scale(scale),
        "photographs": {one.file: _overlap(one, own) for one in photographs},
        "left_out": {one.file: _judged(one, own, trained) for one in left_out},
        "training": {
            "steps": len(trained.psnr),
            "psnr": float(trained.psnr[-100:].mean()),
            "psnr_unit": "dB",
        },
        "findings": [
            {"what": one.what, "where": one.where, "remedy": one.remedy} for one in findings
        ],
        "seconds": seconds,
        "versions": versions(),
        "configuration": configuration,
    }
    write_json(folder / "result.json", record)
    return record


def _scale(scale: MetricScale) -> dict[str, Any]:
    return {
        "factor": scale.factor,
        "relative_deviation": scale.deviation,
        "relative_deviation_of_diffusivity": 2.0 * scale.deviation,
        "source": scale.source,
    }


def _overlap(photograph: Photograph, surface: Surface) -> dict[str, Any]:
    """How far the surface's silhouette and the mask overlap [1]."""
    if photograph.mask is None:
        return {"silhouette_overlap": None}
    shape = silhouette(photograph.camera, surface)
    return {"silhouette_overlap": overlap(shape, photograph.mask > 0.5)}


def _judged(photograph: Photograph, surface: Surface, trained: Trained) -> dict[str, Any]:
    """The same with how alike picture and photograph are [dB]; None where it shows nothing."""
    alike = psnr(picture(trained, photograph.camera), photograph)
    found = {"psnr": alike if np.isfinite(alike) else None, "psnr_unit": "dB"}
    return found | _overlap(photograph, surface)

"""Layers of values sent to a running Rerun viewer."""

from __future__ import annotations

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, UInt8

from thermo.errors import InputError

from ._viewer import Layer, Viewer

_MAPS: Final = {"temperature": "inferno", "residual": "coolwarm", "field": "viridis"}


def log_to_rerun(stream: Any, viewer: Viewer) -> None:
    """Send a surface and its layers to Rerun, one entity a layer, one step a frame.

    Call it again with what is new while a run goes on: later frames of a layer of the same name go
    on in its timeline `time` [s]. Colours span the values that are sent at once; residuals are
    symmetric about zero. Values that are not known are grey.

    Arguments: `stream`, a `rerun.RecordingStream` that was told where to send (`spawn`,
    `connect_grpc` or `save`).

    Needs the extra `thermofield[rerun]`; raises `InputError` where that is missing.
    """
    try:
        import rerun  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise InputError(
            "a live view needs an extra package", where="log_to_rerun", value="no rerun",
            limit="the package rerun-sdk", remedy="pip install 'thermofield[rerun]'",
        ) from error  # fmt: skip
    for layer in viewer.layers:
        colours = _colours(layer)
        for number, frame in enumerate(colours):
            if layer.time is not None:
                stream.set_time("time", duration=float(layer.time[number]))
            mesh = rerun.Mesh3D(
                vertex_positions=viewer.vertices, triangle_indices=viewer.triangles,
                vertex_colors=frame,
            )  # fmt: skip
            stream.log(f"object/{layer.name} [{layer.unit}]", mesh, static=layer.time is None)


def _colours(layer: Layer) -> UInt8[np.ndarray, "frames vertices 3"]:
    known = layer.values[np.isfinite(layer.values)]
    low, high = float(known.min()), float(known.max())
    if layer.kind == "residual":
        high = max(abs(low), abs(high))
        low = -high
    shares = _shares(layer.values, low, high)
    colours = mpl.colormaps[_MAPS[layer.kind]](shares, bytes=True)[..., :3].astype(np.uint8)
    colours[np.isnan(layer.values)] = 128
    return colours


def _shares(
    values: Float[np.ndarray, "frames vertices"], low: float, high: float
) -> Float[np.ndarray, "frames vertices"]:
    return np.nan_to_num((values - low) / (high - low if high > low else 1.0))

"""Layers of values sent to a running Rerun viewer."""

from __future__ import annotations

from typing import Any

from thermo.errors import InputError

from ._viewer import Viewer
from ._viewer_data import coloured


def log_to_rerun(stream: Any, viewer: Viewer) -> None:
    """Send a surface and its layers to Rerun, one entity a layer, one step a frame.

    Call it again with what is new while a run goes on: later frames of a layer of the same name go
    on in its timeline `time` [s]. Colours are those of `write_viewer`'s page; they span the
    values that are sent at once. Values that are not known are grey.

    Arguments: `stream`, a `rerun.RecordingStream` that was told where to send (`spawn`,
    `connect_grpc` or `save`); `viewer`, positions [m] and layers [SI].

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
        for number, frame in enumerate(coloured(layer)):
            if layer.time is not None:
                stream.set_time("time", duration=float(layer.time[number]))
            mesh = rerun.Mesh3D(
                vertex_positions=viewer.vertices, triangle_indices=viewer.triangles,
                vertex_colors=frame,
            )  # fmt: skip
            stream.log(f"object/{layer.name} [{layer.unit}]", mesh, static=layer.time is None)

"""The arrays of the viewer as its page holds them: rounded, little-endian, as text."""

from __future__ import annotations

import base64
from typing import Any

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, UInt8, UInt16
from matplotlib.colors import LogNorm

from ._figure_field import colour_norm
from ._viewer import Layer, Readings, Viewer

UNKNOWN = 65535
"""Code of a value that is not known [1]; those that are have codes from 0 to one less."""
_STEPS = UNKNOWN - 1
_COLOURS = 256
_GREY = 128
# By kind, a colour map and the part of it that is used: black and white have no hue to read.
_MAPS = {
    "temperature": ("inferno", 0.16, 0.97),
    "residual": ("coolwarm", 0.0, 1.0),
    "field": ("viridis", 0.0, 1.0),
}


def viewer_record(viewer: Viewer) -> dict[str, Any]:
    """What the page of a viewer holds [SI]: text, numbers, and arrays as base64.

    Positions are single precision from `centre` [m], so that an object far from the origin keeps
    its shape.
    """
    ends = np.stack([viewer.vertices.min(axis=0), viewer.vertices.max(axis=0)])
    centre = ends.mean(axis=0)
    return {
        "format": "thermofield-viewer/1",
        "title": viewer.title,
        "centre": centre.tolist(),
        "vertices": _text(viewer.vertices - centre, "<f4"),
        "triangles": _text(viewer.triangles, "<u4"),
        "frame": opening_frame(viewer.layers[0]),
        "layers": [_layer(one) for one in viewer.layers],
        "readings": None if viewer.readings is None else _readings(viewer.readings, centre),
        "maps": {kind: _text(_palette(kind), "u1") for kind in _MAPS},
    }


def opening_frame(layer: Layer) -> int:
    """The first frame [1] in which a layer's known values differ most: max - min [its unit].

    A body that is heated begins with one temperature all over, which shows nothing of it.
    """
    known = np.isfinite(layer.values)
    highest = np.where(known, layer.values, -np.inf).max(axis=1)
    lowest = np.where(known, layer.values, np.inf).min(axis=1)
    return int(np.argmax(highest - lowest))


def coloured(layer: Layer) -> UInt8[np.ndarray, "frames vertices 3"]:
    """Red, green and blue [1] of a layer's values, as the page shows them; grey for NaN."""
    low, high, log = scale_of(layer.values, layer.kind)
    codes = encode(layer.values, low, high, log)
    shares = np.minimum(codes, _STEPS) / _STEPS
    colours = _palette(layer.kind)[np.rint((_COLOURS - 1) * shares).astype(int)]
    colours[codes == UNKNOWN] = _GREY
    return colours


def encode(
    values: Float[np.ndarray, "frames places"], low: float, high: float, log: bool
) -> UInt16[np.ndarray, "frames places"]:
    """Codes of values between `low` and `high` [their unit]; `UNKNOWN` for NaN.

    code = round(65534 (v - low) / (high - low)), of logarithms where `log`: a value is off by
    at most half a step.
    """
    ends = np.log([low, high]) if log else np.array([low, high])
    with np.errstate(invalid="ignore"):
        share = ((np.log(values) if log else values) - ends[0]) / (ends[1] - ends[0])
    codes = np.rint(_STEPS * np.clip(share, 0.0, 1.0))
    return np.where(np.isnan(values), UNKNOWN, codes).astype(np.uint16)


def scale_of(values: Float[np.ndarray, "frames places"], kind: str) -> tuple[float, float, bool]:
    """Both ends of a layer's colours [its unit], over all frames, and whether they are logarithmic.

    A residual's are symmetric about zero; a field's are logarithmic where it is positive and
    exceeds a decade, as in the project's figures.
    """
    if kind == "residual":
        most = float(np.nanmax(np.abs(values))) or 1.0
        return -most, most, False
    norm = colour_norm(values.ravel())
    ends = norm.vmin, norm.vmax
    assert ends[0] is not None and ends[1] is not None
    return float(ends[0]), float(ends[1]), kind == "field" and isinstance(norm, LogNorm)


def _layer(layer: Layer) -> dict[str, Any]:
    low, high, log = scale_of(layer.values, layer.kind)
    return {
        "name": layer.name,
        "unit": layer.unit,
        "kind": layer.kind,
        "time": None if layer.time is None else layer.time.tolist(),
        "low": low,
        "high": high,
        "log": log,
        "codes": _text(encode(layer.values, low, high, log), "<u2"),
    }


def _readings(readings: Readings, centre: Float[np.ndarray, "3"]) -> dict[str, Any]:
    low, high, _ = scale_of(readings.values, "temperature")
    return {
        "points": _text(readings.points - centre, "<f4"),
        "time": readings.time.tolist(),
        "low": low,
        "high": high,
        "codes": _text(encode(readings.values, low, high, False), "<u2"),
    }


def _palette(kind: str) -> UInt8[np.ndarray, "colours 3"]:
    name, first, last = _MAPS[kind]
    found = np.asarray(mpl.colormaps[name](np.linspace(first, last, _COLOURS)))
    return np.rint(255 * found[:, :3]).astype(np.uint8)


def _text(array: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")

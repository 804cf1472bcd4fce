"""What the viewer shows: a surface, layers of values on it, and readings."""

from __future__ import annotations

from typing import Literal, final, get_args

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import check_time, real_array

Kind = Literal["temperature", "residual", "field"]

MOST_VALUES = 30_000_000
"""Most values of all layers and readings [1] that one page holds: 60 million bytes, and a third
more as text."""


@final
class Layer(eqx.Module):
    """Values at the vertices of a surface, steady or over time; all leaves are NumPy arrays.

    Arguments:

    - `name`: what the page calls it, such as `temperature`; `unit`: SI, `1` for none.
    - `time`: of the frames, (frames,) [s], increasing, or None for values that do not change.
    - `values`: (frames, vertices), or (vertices,) without a time, in `unit`. NaN where the value
      is not known: the page hatches those places.
    - `kind`: `temperature` [K], which the page also shows in degrees Celsius; `residual`,
      simulation less readings, in colours that are symmetric about zero; or `field`.

    `values` is kept as (frames, vertices), with one frame where there is no time.

    Raises `InputError` for no name, an unknown kind, shapes that do not fit, times that do not
    increase, values that are infinite, and where no value is known.
    """

    name: str = eqx.field(static=True)
    unit: str = eqx.field(static=True)
    time: Float[np.ndarray, " times"] | None
    values: Float[np.ndarray, "frames vertices"]
    kind: Kind = eqx.field(static=True)

    def __init__(
        self, name: str, unit: str, time: ArrayLike | None, values: ArrayLike, kind: str
    ) -> None:
        where = f"layer {name}"
        self.name, self.unit = _word(name, "layer: name"), _word(unit, f"{where}: unit")
        self.kind = _kind(kind, unit, where)
        self.time = _time(time, where)
        self.values = _values(values, self.time, where)


@final
class Readings(eqx.Module):
    """Temperatures that were read at points, to be shown as dots; all leaves are NumPy arrays.

    Arguments: `points` (samples, 3) [m]; `time` (frames,) [s], increasing; `values`
    (frames, samples) [K], NaN where there is no reading.

    Raises `InputError` as `Layer` does.
    """

    points: Float[np.ndarray, "samples 3"]
    time: Float[np.ndarray, " frames"]
    values: Float[np.ndarray, "frames samples"]

    def __init__(self, points: ArrayLike, time: ArrayLike, values: ArrayLike) -> None:
        self.points = _places(points, "readings: points")
        self.time = check_time(time, where="readings: time", earliest=None, least_frames=1)
        self.values = _values(values, self.time, "readings")
        _fits(self.values, len(self.points), "readings: values", "points")


@final
class Viewer(eqx.Module):
    """A surface with layers of values, of which the page shows one at a time.

    Arguments:

    - `title`: of the page.
    - `vertices`: (vertices, 3) [m]. `triangles`: (triangles, 3), numbers of vertices from 0.
    - `layers`: at least one, with different names. Temperatures are put first, then residuals.
    - `readings`: shown as dots, or None.

    Raises `InputError` for shapes that do not fit, positions that are not finite, triangles
    without their vertices, layers of another number of vertices or of one name, and for more
    than `MOST_VALUES` values.
    """

    title: str = eqx.field(static=True)
    vertices: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "triangles 3"]
    layers: tuple[Layer, ...]
    readings: Readings | None

    def __init__(
        self,
        title: str,
        vertices: ArrayLike,
        triangles: ArrayLike,
        layers: tuple[Layer, ...],
        readings: Readings | None = None,
    ) -> None:
        self.title = _word(title, "viewer: title")
        self.vertices = _places(vertices, "viewer: vertices")
        self.triangles = _triangles(triangles, len(self.vertices))
        for layer in layers:
            _fits(layer.values, len(self.vertices), f"layer {layer.name}: values", "vertices")
        self.layers = _in_order(layers)
        self.readings = readings
        _small_enough([*(one.values for one in layers), *([readings.values] if readings else [])])


def _word(word: object, where: str) -> str:
    if not isinstance(word, str) or not word.strip():
        raise InputError(
            "this is no text", where=where, value=repr(word), limit="at least one letter",
            remedy="give a name that a reader understands; the unit of a pure number is 1",
        )  # fmt: skip
    return word


def _kind(kind: str, unit: str, where: str) -> Kind:
    for known in get_args(Kind):
        if kind == known and (kind != "temperature" or unit == "K"):
            return known
    raise InputError(
        "there is no such kind of layer", where=where, value=f"{kind} in {unit}",
        limit="temperature in K, residual or field",
        remedy="give temperatures in kelvin; the page shows degrees Celsius as well",
    )  # fmt: skip


def _time(time: ArrayLike | None, where: str) -> np.ndarray | None:
    if time is None:
        return None
    return check_time(time, where=f"{where}: time", earliest=None, least_frames=1)


def _values(values: ArrayLike, time: np.ndarray | None, where: str) -> np.ndarray:
    array = real_array(values, where=f"{where}: values", quantity="values")
    if time is None and array.ndim == 1:
        array = array[None]
    frames = 1 if time is None else len(time)
    if array.ndim != 2 or len(array) != frames:
        raise InputError(
            "values do not fit their times", where=f"{where}: values",
            value=f"shape {array.shape}", limit=f"{frames} frames, one row each",
            remedy="store one row a frame and one column a place",
        )  # fmt: skip
    wrong = np.isinf(array)
    if wrong.any() or not np.isfinite(array).any():
        raise InputError(
            "values are not finite", where=f"{where}: values",
            value=f"{wrong.sum()} infinite, {np.isnan(array).sum()} NaN of {array.size}",
            limit="finite numbers, or NaN in some places", remedy="leave this layer out",
        )  # fmt: skip
    return array


def _places(points: ArrayLike, where: str) -> np.ndarray:
    array = real_array(points, where=where, quantity="positions [m]")
    if array.ndim != 2 or array.shape[1:] != (3,) or not len(array):
        raise InputError(
            "positions have the wrong shape", where=where, value=f"shape {array.shape}",
            limit="(points, 3), at least one point", remedy="store one row of x, y, z in metres",
        )  # fmt: skip
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise InputError(
            "positions are not finite", where=where, value=f"row {bad[0]}: {array[bad[0]]}",
            limit="finite metres", remedy="drop the places whose position is unknown",
        )  # fmt: skip
    return array


def _triangles(triangles: ArrayLike, vertices: int) -> np.ndarray:
    array = np.asarray(triangles)
    whole = array.dtype.kind in "iu" and array.ndim == 2 and array.shape[1:] == (3,)
    if not whole or not array.size or array.min() < 0 or array.max() >= vertices:
        found = f"from {array.min()} to {array.max()}" if whole and array.size else "no triangles"
        raise InputError(
            "the triangles do not fit the vertices", where="viewer: triangles",
            value=f"shape {array.shape}, type {array.dtype}, {found}",
            limit=f"(triangles, 3) whole numbers from 0 to {vertices - 1}",
            remedy="give the numbers of three vertices a triangle, counted from 0",
        )  # fmt: skip
    return array


def _fits(values: np.ndarray, count: int, where: str, places: str) -> None:
    if values.shape[1] != count:
        raise InputError(
            f"values do not fit the {places}", where=where,
            value=f"{values.shape[1]} values a frame", limit=f"{count}, one for each place",
            remedy=f"give the values at the same {places}, in their order",
        )  # fmt: skip


def _in_order(layers: tuple[Layer, ...]) -> tuple[Layer, ...]:
    """Temperatures first, then residuals, then fields; the order that was given among these."""
    names = [layer.name for layer in layers]
    if not names or len(set(names)) < len(names):
        raise InputError(
            "the layers cannot be told apart", where="viewer: layers",
            value=", ".join(names) or "none", limit="at least one layer, of different names",
            remedy="give each layer a name of its own",
        )  # fmt: skip
    return tuple(sorted(layers, key=lambda layer: get_args(Kind).index(layer.kind)))


def _small_enough(arrays: list[np.ndarray]) -> None:
    total = sum(one.size for one in arrays)
    if total > MOST_VALUES:
        raise InputError(
            "these are too many values for one page", where="viewer: layers", value=total,
            limit=f"at most {MOST_VALUES}", remedy="give fewer frames, for example every second",
        )  # fmt: skip

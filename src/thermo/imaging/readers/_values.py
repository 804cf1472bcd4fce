"""From what a file stores to frames in kelvin or counts, in one pass and single precision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Shaped

from thermo.errors import InputError
from thermo.imaging._frames import Frames
from thermo.observe import COLDEST, real_array

from ._stated import UNITS, Stated
from ._times import times_of

_ZERO_C: Final = 273.15

_EVERYDAY: Final = (250.0, 400.0)
_WARM: Final = 200.0
"""Numbers with a middle as kelvin of everyday scenes have it, of which none is below what air and
walls about a hot object have in Celsius: these are kelvin."""

_NAMES: Final = {
    "k": "K", "kelvin": "K", "c": "C", "°c": "C", "degc": "C", "celsius": "C",
    "degrees celsius": "C", "counts": "counts", "count": "counts", "dl": "counts",
}  # fmt: skip


def unit_named(text: str, *, where: str) -> str:
    """The unit ("K", "C" or "counts") that a file names, or `InputError`."""
    name = _NAMES.get(text.strip().casefold())
    if name is None:
        raise InputError(
            "the file names an unknown unit", where=where, value=repr(text),
            limit=", ".join(UNITS), remedy="write one of these units into the file",
        )  # fmt: skip
    return name


def frames_of(
    values: Shaped[np.ndarray, "..."],
    given: Stated,
    *,
    where: str,
    unit: str | None = None,
    stamps: Float[np.ndarray, " stamps"] | None = None,
    valid: Bool[np.ndarray, "..."] | None = None,
    names: Sequence[str] = (),
) -> Frames:
    """Frames from a stack of values as stored; one image is a stack of one.

    Arguments: `unit` that the file names ("K", "C", "counts") or None; `stamps` of the file [s];
    `valid`, where it says so; `names` of the single files. Values in the file's own float32 array
    are converted in place.

    Without any unit whole numbers are counts and others kelvin. Raises `InputError`.
    """
    stack = values[None] if values.ndim == 2 else values
    if stack.dtype.kind not in "fiu" or stack.ndim != 3 or 0 in stack.shape:
        stack = real_array(stack, where=where, quantity="frames")
        return Frames([0.0], stack, where=where)  # raises: these are no frames
    if stack.dtype.itemsize == 1:
        raise InputError(
            "eight bits are a picture, not a measurement", where=where, value=str(stack.dtype),
            limit="16-bit whole numbers, or floating-point numbers",
            remedy="export the radiometric data, not the picture that the camera's program shows",
        )  # fmt: skip
    found = _unit(stack, given, unit, where)
    kept = _converted(stack, given, found)
    _check_frames(kept, names, where)
    _check_unit(kept, found, given, where)
    time = times_of(len(kept), given, stamps=stamps, where=where)
    return Frames(time, kept, valid, counts=found == "counts", where=where)


def _unit(stack: np.ndarray, given: Stated, said: str | None, where: str) -> str:
    if said is not None and given.unit is not None and said != given.unit:
        raise InputError(
            "the file and the settings name different units", where=where,
            value=f"the file {said}, the settings {given.unit}", limit="the same unit",
            remedy="leave recording.unit out of the settings: the file says it",
        )  # fmt: skip
    found = given.unit or said
    if found is None:
        found = "counts" if stack.dtype.kind in "iu" and not given.scaled() else "K"
    if found == "counts" and given.scaled():
        raise InputError(
            "counts have no scale", where=where, value="`scale` or `offset`, and a file of counts",
            limit="scale and offset for temperatures",
            remedy="leave them out: calibrate counts by a radiometry instead",
        )  # fmt: skip
    return found


def _converted(stack: np.ndarray, given: Stated, unit: str) -> np.ndarray:
    scale = 1.0 if given.scale is None else given.scale
    offset = (0.0 if given.offset is None else given.offset) + (_ZERO_C if unit == "C" else 0.0)
    plain = scale == 1.0 and offset == 0.0
    if stack.dtype == np.float32 and plain:
        return stack
    in_place = stack.dtype == np.float32 and stack.flags.writeable
    out = stack if in_place else np.empty(stack.shape, np.float32)
    with np.errstate(over="ignore"):  # beyond single precision is infinite, and refused below
        for row, image in zip(out, stack, strict=True):
            row[...] = image if plain else image.astype(np.float64) * scale + offset
    return out


def _check_frames(values: np.ndarray, names: Sequence[str], where: str) -> None:
    for index, image in enumerate(values):
        name = f"{where}: {names[index]}" if names else where
        if np.isnan(image).all():
            raise InputError(
                "a frame without any value", where=name, value=f"only NaN in frame {index}",
                limit="a number in at least one pixel of each frame",
                remedy="drop this frame and its time",
            )  # fmt: skip
        if np.isinf(image).any():
            raise InputError(
                "infinite values", where=name,
                value=f"{int(np.isinf(image).sum())} in frame {index}",
                limit="finite numbers, NaN where there is none",
                remedy="replace infinite values by NaN",
            )  # fmt: skip


def _check_unit(values: np.ndarray, unit: str, given: Stated, where: str) -> None:
    middle = float(np.nanmedian(values[0]))
    if unit == "C" and _EVERYDAY[0] <= middle - _ZERO_C <= _EVERYDAY[1]:
        lowest = float(np.nanmin(values)) - _ZERO_C
        if lowest > _WARM:
            raise InputError(
                "temperatures said to be Celsius look like kelvin", where=where,
                value=f"{lowest:g} at least, {middle - _ZERO_C:g} in the middle of frame 0",
                limit=f"Celsius of a scene that is not above {_WARM:g} C everywhere",
                remedy="state recording.unit=K; if they truly are Celsius, store them in kelvin",
            )  # fmt: skip
    if unit == "K" and middle < COLDEST and not given.scaled():
        raise InputError(
            "temperature that cannot be kelvin", where=where,
            value=f"{middle:g} in the middle of frame 0", limit=f"kelvin, at least {COLDEST:g} K",
            remedy="if they are degrees Celsius state recording.unit=C, if a signal counts",
        )  # fmt: skip

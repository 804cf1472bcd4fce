"""One recording: the surface temperature of some samples over time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from thermo.errors import InputError

from ._kelvin import check_kelvin
from ._number import real_array


@final
class Recording(eqx.Module):
    """Temperatures of surface samples at the camera's frames, all leaves NumPy arrays.

    Arguments:

    - `points`: positions of the samples on or close to the surface, (samples, 3) [m].
    - `time`: times of the frames, (frames,) [s], increasing; the run starts at 0.
    - `temperature`: (frames, samples) [K]; NaN where a value is missing.
    - `valid`: false where a value must not be used, (frames, samples) or (samples,); all true
        where it is left out. A missing value is never valid.
    - `quiet`: frames of the isothermal object before time 0, (quiet frames, samples) [K], or
        None. They may hold NaN.
    - `where`: what messages call this recording, usually its file.

    After construction `temperature` is finite everywhere, so that gradients stay finite: where
    `valid` is false it holds a placeholder, the mean of the sample's valid frames.

    Raises `InputError` for shapes that do not fit, fewer than two frames, no valid value, time
    that does not increase, non-finite points or times, and temperatures that cannot be kelvin.
    """

    points: Float[np.ndarray, "samples 3"]
    time: Float[np.ndarray, " frames"]
    temperature: Float[np.ndarray, "frames samples"]
    valid: Bool[np.ndarray, "frames samples"]
    quiet: Float[np.ndarray, "quiet samples"] | None

    def __init__(
        self,
        points: ArrayLike,
        time: ArrayLike,
        temperature: ArrayLike,
        valid: ArrayLike | None = None,
        quiet: ArrayLike | None = None,
        *,
        where: str = "recording",
    ) -> None:
        self.points = _points(points, where)
        self.time = check_time(time, where=f"{where}: time")
        measured = _temperature(temperature, (self.time.size, len(self.points)), where)
        given = _valid(valid, measured.shape, where)
        check_kelvin(measured, where=f"{where}: temperature", used=given)
        self.valid = given & ~np.isnan(measured)
        _enough(self.valid, where)
        self.temperature = _filled(measured, self.valid)
        self.quiet = None if quiet is None else _quiet(quiet, len(self.points), where)

    def knows_quiet(self) -> bool:
        """Whether there are enough quiet frames, three, to tell noise and constant errors [K]."""
        return self.quiet is not None and len(self.quiet) >= 3


def check_time(
    time: object, *, where: str, earliest: float | None = 0.0, least_frames: int = 2
) -> Float[np.ndarray, " frames"]:
    """Return strictly increasing finite times [s], or raise `InputError` naming `where`."""
    values = real_array(time, where=where, quantity="time [s]")
    if values.ndim != 1 or values.size < least_frames:
        raise InputError(
            "too few frames", where=where,
            value=f"{values.size} frames" if values.ndim == 1 else f"shape {values.shape}",
            limit=f"shape (frames,) with at least {least_frames} frames",
            remedy="give a record of the temperature over time; one frame shows no heat flow",
        )  # fmt: skip
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            "time is not finite", where=where, value=f"{values[bad[0]]} at frame {bad[0]}",
            limit="finite seconds", remedy="drop the frames without a time stamp",
        )  # fmt: skip
    back = np.flatnonzero(np.diff(values) <= 0)
    if back.size:
        i = int(back[0])
        raise InputError(
            "time does not increase", where=where,
            value=f"{values[i]:g} s at frame {i}, then {values[i + 1]:g} s",
            limit="strictly increasing seconds",
            remedy="sort the frames by time and drop repeated time stamps",
        )  # fmt: skip
    if earliest is not None and values[0] < earliest:
        raise InputError(
            "frames before the start of the run", where=where, value=f"{values[0]:g} s",
            limit=f"at least {earliest:g} s",
            remedy="the run starts at t = 0; store earlier frames as `quiet`",
        )  # fmt: skip
    return values


def _points(points: object, where: str) -> np.ndarray:
    place = f"{where}: points"
    values = real_array(points, where=place, quantity="points [m]")
    if values.ndim != 2 or values.shape[1] != 3 or len(values) == 0:
        raise InputError(
            "points have the wrong shape", where=place, value=f"shape {values.shape}",
            limit="shape (samples, 3), at least one sample",
            remedy="store one row of x, y, z in metres a sample",
        )  # fmt: skip
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if bad.size:
        raise InputError(
            "points are not finite", where=place,
            value=f"{bad.size} samples, the first is sample {bad[0]}: {values[bad[0]].tolist()}",
            limit="finite metres", remedy="drop the samples whose position is unknown",
        )  # fmt: skip
    return values


def _temperature(temperature: object, shape: tuple[int, int], where: str) -> np.ndarray:
    place = f"{where}: temperature"
    values = real_array(temperature, where=place, quantity="temperature [K]")
    if values.shape != shape:
        remedy = "store one row a frame and one column a sample"
        if values.shape == shape[::-1]:
            remedy = "transpose it: " + remedy
        raise InputError(
            "temperature does not fit time and points", where=place,
            value=f"shape {values.shape}", limit=f"shape (frames, samples) = {shape}",
            remedy=remedy,
        )  # fmt: skip
    return values


def _valid(valid: object, shape: tuple[int, ...], where: str) -> np.ndarray:
    if valid is None:
        return np.ones(shape, dtype=bool)
    values = np.asarray(valid)
    plain = values.dtype.kind == "b" or (
        values.dtype.kind in "iu" and bool(np.isin(values, (0, 1)).all())
    )
    if not plain or values.shape not in (shape, shape[1:]):
        raise InputError(
            "valid does not fit temperature", where=f"{where}: valid",
            value=f"shape {values.shape}, type {values.dtype}",
            limit=f"true or false, shape {shape} or {shape[1:]}",
            remedy="store true where a temperature may be used and false elsewhere",
        )  # fmt: skip
    return np.broadcast_to(values.astype(bool), shape).copy()


def _enough(valid: np.ndarray, where: str) -> None:
    frames = int(valid.any(axis=1).sum())
    if frames < 2:
        raise InputError(
            "no usable temperatures" if frames == 0 else "temperatures in one frame only",
            where=f"{where}: temperature", value=f"{frames} of {len(valid)} frames hold a value",
            limit="at least two frames with a valid temperature",
            remedy="NaN and false in `valid` mean missing: check the export of the recording",
        )  # fmt: skip


def _quiet(quiet: object, samples: int, where: str) -> np.ndarray:
    place = f"{where}: quiet"
    values = real_array(quiet, where=place, quantity="quiet frames [K]")
    if values.ndim != 2 or values.shape[1] != samples or len(values) == 0:
        raise InputError(
            "quiet frames do not fit points", where=place, value=f"shape {values.shape}",
            limit=f"shape (quiet frames, samples) with {samples} samples",
            remedy="store one row a quiet frame and one column a sample, or leave `quiet` out",
        )  # fmt: skip
    check_kelvin(values, where=place)
    return values


def _filled(measured: np.ndarray, valid: np.ndarray) -> np.ndarray:
    kept = np.where(valid, measured, 0.0)
    count = valid.sum(axis=0)
    overall = kept.sum() / count.sum()
    mean = np.where(count > 0, kept.sum(axis=0) / np.maximum(count, 1), overall)
    return np.where(valid, measured, mean)

"""Frames of one or several cameras, brought to samples of a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from thermo.errors import InputError
from thermo.observe import Recording, check_number

from ._camera import Camera
from ._frames import Frames
from ._surface_samples import SurfaceSamples


def register_frames(
    samples: SurfaceSamples,
    cameras: Sequence[Camera],
    frames: Sequence[Frames],
    *,
    together: float | int = 1e-3,
    where: str = "frames",
) -> Recording:
    """Bring frames to samples of a surface, one temperature a sample and moment [K].

    Where several cameras read a sample at one moment, the mean is taken with weights 1 / a^2, a the
    footprint: a camera that has more pixels on a place tells more of it. Nothing is interpolated
    over time; where no camera has a usable frame a sample is not valid. Frames before time 0 are
    the recording's quiet ones.

    Arguments:

    - `samples`: of `place_samples` or `samples_at`, for the same cameras.
    - `cameras`, `frames`: one of each, in the same order; a camera that moves is one for each of
      its pictures. Frames hold kelvin; the run starts at time 0 [s].
    - `together`: frames less than this apart are of one moment [s].
    - `where`: what messages call the frames.

    Raises `InputError` where frames and cameras differ in number or size, or hold a sensor's
    signal.

    Source: paper, appendix B.6 (checklist D1, D3).
    """
    moments, temperature = fused(samples, cameras, frames, together=together, where=where)
    quiet, later = moments < 0, moments >= 0
    return Recording(
        samples.points, moments[later], temperature[later], ~np.isnan(temperature[later]),
        temperature[quiet] if quiet.any() else None, where=where,
    )  # fmt: skip


def fused(
    samples: SurfaceSamples,
    cameras: Sequence[Camera],
    frames: Sequence[Frames],
    *,
    together: float | int = 1e-3,
    where: str = "frames",
) -> tuple[Float[np.ndarray, " moments"], Float[np.ndarray, "moments samples"]]:
    """All moments [s] and the temperatures of the samples [K], NaN where none is usable.

    Arguments and what it raises: as for `register_frames`.
    """
    check_frames(cameras, frames, where)
    apart = check_number(together, where="together", quantity="time between frames [s]", least=0.0)
    moments, rows = _moments([one.time for one in frames], apart)
    total = np.zeros((len(moments), len(samples.points)))
    weight = np.zeros_like(total)
    for number, (one, row) in enumerate(zip(frames, rows, strict=True)):
        seen = np.flatnonzero(samples.seen[number])
        values, valid = _read(one, samples.pixels[number, seen], samples.weights[number, seen])
        trust = valid / samples.footprint[number, seen] ** 2
        place = np.ix_(row, seen)
        total[place] += trust * values
        weight[place] += trust
    return moments, np.where(weight > 0, total / np.where(weight > 0, weight, 1.0), np.nan)


def _read(
    frames: Frames, pixels: Int[np.ndarray, "samples 4"], weights: Float[np.ndarray, "samples 4"]
) -> tuple[Float[np.ndarray, "frames samples"], Bool[np.ndarray, "frames samples"]]:
    """Temperatures [K] by interpolation, and where all pixels that take part are valid."""
    flat = frames.values.reshape(len(frames.values), -1)
    used = frames.valid.reshape(len(frames.valid), -1)
    values, valid = 0.0, True
    for corner in range(pixels.shape[1]):
        share, pixel = weights[:, corner], pixels[:, corner]
        fine = used[:, pixel] | (share == 0.0)
        # Taken out before it is weighed: no weight makes a number of NaN.
        values = values + share * np.where(fine, flat[:, pixel], 0.0).astype(float)
        valid = valid & fine
    return np.asarray(values), np.asarray(valid)


def _moments(
    times: Sequence[Float[np.ndarray, " _"]], apart: float
) -> tuple[Float[np.ndarray, " moments"], list[Int[np.ndarray, " _"]]]:
    """Times at which there are frames [s], and the number of that of each frame."""
    every = np.concatenate(times)
    order = np.argsort(every, kind="stable")
    begins = np.concatenate([[True], np.diff(every[order]) > apart])
    number = np.empty(len(every), int)
    number[order] = np.cumsum(begins) - 1
    mean = np.bincount(number, every) / np.bincount(number)
    cuts = np.cumsum([len(one) for one in times])[:-1]
    rows = np.split(number, cuts)
    for row in rows:
        if len(np.unique(row)) != len(row):
            raise InputError(
                "two frames of one camera are of one moment", where="together",
                value=f"{apart:g} s", limit="less than the time between two frames",
                remedy="lower `together`",
            )  # fmt: skip
    return mean, rows


def check_count(recordings: int, cameras: int, *, where: str) -> None:
    """Raise `InputError` unless there are as many recordings as cameras, and at least one."""
    if recordings != cameras or not cameras:
        raise InputError(
            "frames and cameras differ in number", where=where,
            value=f"{recordings} recordings, {cameras} cameras",
            limit="one recording a camera, at least one",
            remedy="give frames=[a,b], one a camera, in the order of the cameras",
        )  # fmt: skip


def check_frames(cameras: Sequence[Camera], frames: Sequence[Frames], where: str) -> None:
    """Raise `InputError` unless there is one recording a camera, of its size and in kelvin [K]."""
    check_count(len(frames), len(cameras), where=where)
    for camera, one in zip(cameras, frames, strict=True):
        if one.size() != (camera.height, camera.width):
            rows, columns = one.size()
            raise InputError(
                "frames are of another size than their camera", where=f"{where}: {camera.name}",
                value=f"{columns} x {rows} pixels",
                limit=f"{camera.width} x {camera.height}, as the camera was calibrated for",
                remedy="give the calibration of these frames; a part cut out has its own c_x, c_y",
            )  # fmt: skip
        if one.counts:
            raise InputError(
                "these frames hold a sensor's signal", where=f"{where}: {camera.name}",
                value="counts", limit="temperatures [K]",
                remedy="of scaled temperatures state recording.scale (0.01 of centikelvin); a "
                "signal needs optics.planck, see docs/radiometry.md",
            )  # fmt: skip

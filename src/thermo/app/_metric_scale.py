"""The length of the cameras' unit, from what a command was given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.imaging import View, pixel_centres, rays
from thermo.observe import real_array
from thermo.reconstruct import (
    MetricScale,
    Trained,
    picture,
    scale_from_depths,
    scale_from_distances,
    scale_from_length,
)

WAYS = ("length", "cameras", "depths")
_LENGTH = ("from", "to", "metres", "deviation")

Depths = Mapping[int, Float[np.ndarray, "rows columns"]]


def stated_scale(settings: Mapping[str, Any], views: Sequence[View]) -> MetricScale | Depths | None:
    """What `scale` says, None where it says nothing: read and refused before any training.

    Depths [m] by the number of their camera wait for a surface to be compared with.

    Raises `InputError` for what is no scale, for two of them, and for one beside `camera_scale`.
    """
    given = {way: settings["scale"][way] for way in WAYS if settings["scale"][way] is not None}
    if not given:
        return None
    if len(given) > 1 or settings["camera_scale"] is not None:
        told = [f"scale.{way}" for way in given]
        told += ["camera_scale"] if settings["camera_scale"] is not None else []
        raise InputError(
            "the length of the cameras' unit is told in two ways", where="scale",
            value=" and ".join(told), limit="one of them", remedy="leave the others out",
        )  # fmt: skip
    way, value = next(iter(given.items()))
    if way == "length":
        return _from_length(value)
    if way == "cameras":
        return _from_cameras(Path(str(value)), views)
    return _depths(Path(str(value)), views)


def scale_of(
    stated: MetricScale | Depths | None, views: Sequence[View], trained: Trained
) -> MetricScale | None:
    """The scale that was stated, or that which stated depths and a surface give.

    Depth cameras give the distance along their axis [m]; the rebuilt one is brought to that.

    Raises `InputError` where depths meet the surface in fewer than three pictures.
    """
    if stated is None or isinstance(stated, MetricScale):
        return stated
    measured, rebuilt, group = [], [], []
    for number, depth in stated.items():
        camera = views[number].camera
        along = rays(camera, pixel_centres(camera)) @ camera.pose[2, :3]
        measured.append(depth.ravel())
        rebuilt.append(picture(trained, camera).depth.ravel() * along)
        group.append(np.full(depth.size, number))
    return scale_from_depths(*(np.concatenate(one) for one in (measured, rebuilt, group)))


def _from_length(value: Any) -> MetricScale:
    if not isinstance(value, Mapping) or set(value) != set(_LENGTH):
        raise InputError(
            "this is no length", where="scale.length", value=value, limit=", ".join(_LENGTH),
            remedy="give scale.length='{from:[x,y,z],to:[x,y,z],metres:L,deviation:D}'",
        )  # fmt: skip
    ends = [
        real_array(value[key], where=f"scale.length.{key}", quantity="place in the cameras' unit")
        for key in ("from", "to")
    ]
    for key, end in zip(("from", "to"), ends, strict=True):
        if end.shape != (3,):
            raise InputError(
                "this is no place", where=f"scale.length.{key}", value=end.tolist(),
                limit="three numbers", remedy="give [x,y,z] in the cameras' unit",
            )  # fmt: skip
    return scale_from_length(ends[0], ends[1], value["metres"], value["deviation"])


def _from_cameras(path: Path, views: Sequence[View]) -> MetricScale:
    numbers = {
        name: number
        for number, view in enumerate(views)
        for name in (view.camera.name, view.file, Path(view.file).name)
    }
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as fault:
        raise InputError(
            "distances of cameras cannot be read", where=str(path),
            value=f"{type(fault).__name__}", limit="a text file", remedy="see whether it is there",
        ) from fault  # fmt: skip
    pairs, metres = [], []
    for row, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        if words:
            first, second, apart = _pair(words, numbers, f"{path}: line {row}")
            pairs.append((first, second))
            metres.append(apart)
    places = np.stack([view.camera.place() for view in views])
    return scale_from_distances(
        places, np.asarray(pairs, int).reshape(-1, 2), np.asarray(metres, float)
    )


def _pair(words: Sequence[str], numbers: Mapping[str, int], where: str) -> tuple[int, int, float]:
    try:
        first, second, apart = words
        found = numbers[first], numbers[second], float(apart)
    except (ValueError, KeyError) as fault:
        raise InputError(
            "this is no distance of two cameras", where=where, value=" ".join(words),
            limit="two of " + ", ".join(list(numbers)[:6]) + ", ... and metres",
            remedy="write a line a pair: CAMERA CAMERA METRES",
        ) from fault  # fmt: skip
    if found[0] == found[1]:
        raise InputError(
            "a camera has no distance from itself", where=where, value=" ".join(words),
            limit="two cameras", remedy="name another one",
        )  # fmt: skip
    return found


def _depths(folder: Path, views: Sequence[View]) -> Depths:
    found: dict[int, np.ndarray] = {}
    for number, view in enumerate(views):
        path = folder / f"{Path(view.file or view.camera.name).stem}.npy"
        if path.is_file():
            found[number] = _depth(path, view)
    if len(found) < 3:
        raise InputError(
            "there are too few pictures of depths", where=str(folder), value=len(found),
            limit="three and more: fewer do not say how far off they are",
            remedy="call them as the pictures, with the ending .npy",
        )  # fmt: skip
    return found


def _depth(path: Path, view: View) -> Float[np.ndarray, "rows columns"]:
    try:
        values = np.load(path, allow_pickle=False)
    except (OSError, ValueError) as fault:
        raise InputError(
            "depths cannot be read", where=str(path), value=f"{type(fault).__name__}: {fault}",
            limit="a NumPy file of numbers", remedy="write it with numpy.save",
        ) from fault  # fmt: skip
    depth = real_array(values, where=str(path), quantity="depths [m]")
    size = (view.camera.height, view.camera.width)
    if depth.shape != size:
        raise InputError(
            "these depths have another size than their camera", where=str(path),
            value=depth.shape, limit=str(size), remedy="give one depth a pixel of the picture",
        )  # fmt: skip
    return depth

"""Folders of single frames: their order, their times, and that they are of one size."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float, Shaped

from thermo.errors import InputError
from thermo.imaging._frames import Frames
from thermo.observe import TIME, read_table

from ._stated import Stated
from ._values import frames_of

TIMES: Final = "times.csv"
"""Beside single frames: columns `file` and `time_s` (or `time_ms` and so on), a row a frame."""


def frame_files(folder: Path, suffixes: Sequence[str]) -> list[Path]:
    """The files of a folder that end in one of `suffixes`, frame2 before frame10.

    Hidden files are passed over, and `times.csv`.
    """
    found = [
        one for one in folder.iterdir()
        if one.suffix.casefold() in suffixes and not one.name.startswith(".")
        and one.name.casefold() != TIMES and one.is_file()
    ]  # fmt: skip
    return sorted(found, key=lambda one: (_natural(one.name), one.name))


def is_kind(path: Path, suffixes: Sequence[str]) -> bool:
    """Whether a file, or at least one of a folder, ends in one of `suffixes`."""
    if path.is_dir():
        return bool(frame_files(path, suffixes))
    return path.suffix.casefold() in suffixes


def first_bytes(path: Path, count: int) -> bytes:
    """The first `count` bytes of a file; none of a folder or of what cannot be read."""
    try:
        with path.open("rb") as stream:
            return stream.read(count)
    except OSError:
        return b""


def single_frames(
    path: Path,
    suffixes: Sequence[str],
    read: Callable[[Path], Shaped[np.ndarray, "..."]],
    given: Stated,
    *,
    unit: str | None = None,
    dates: Callable[[], Float[np.ndarray, " frames"] | None] = lambda: None,
) -> Frames:
    """Frames [K] or [1] and their times [s] of a file that holds one, or of a folder of them.

    Arguments: what the files' names end in; `read`, which reads one; the `unit` that they name;
    `dates` of the files [s], asked after the last was read where no `times.csv` is beside them.

    Raises `InputError`, naming the files, where they do not belong together, or their times do not
    belong to them.
    """
    files, times = [path], None
    if path.is_dir():
        files, times = _timed(path, frame_files(path, suffixes))
    values = _stacked(files, read)
    names = [one.name for one in files] if path.is_dir() else ()
    stamps = dates() if times is None else times
    return frames_of(values, given, where=str(path), unit=unit, stamps=stamps, names=names)


def _timed(
    folder: Path, files: Sequence[Path]
) -> tuple[list[Path], Float[np.ndarray, " frames"] | None]:
    """Files and their times [s] by `times.csv`, in the order of time; no times without one.

    Raises `InputError` where it does not name each file once with a number.
    """
    table = next((one for one in folder.iterdir() if one.name.casefold() == TIMES), None)
    if table is None:
        return list(files), None
    times = _read_times(table)
    names = {one.name for one in files}
    for wrong, what in ((names - set(times), "has no time"), (set(times) - names, "is absent")):
        if wrong:
            raise InputError(
                f"a frame {what}", where=str(table),
                value=f"{', '.join(sorted(wrong)[:3])} ({len(wrong)} in all)",
                limit="each frame of the folder in one row",
                remedy="complete the table, or drop the frame and its row together",
            )  # fmt: skip
    ordered = sorted(files, key=lambda one: times[one.name])
    return ordered, np.array([times[one.name] for one in ordered])


def _stacked(
    files: Sequence[Path], read: Callable[[Path], Shaped[np.ndarray, "..."]]
) -> Shaped[np.ndarray, "frames rows columns"]:
    """Single frames in one array, filled one after the other.

    Raises `InputError`, naming both files, where sizes or types of number differ.
    """
    first = read(files[0])
    if first.ndim != 2 or 0 in first.shape:
        raise InputError(
            "this is no single frame", where=str(files[0]), value=f"shape {first.shape}",
            limit="one image of one channel", remedy="put stacks into one file, outside the folder",
        )  # fmt: skip
    stack = np.empty((len(files), *first.shape), first.dtype)
    stack[0] = first
    for index, file in enumerate(files[1:], start=1):
        image = read(file)
        for what, here, there in (
            ("sizes", _size(first), _size(image)),
            ("types of number", str(first.dtype), str(image.dtype)),
        ):
            if here != there:
                raise InputError(
                    f"frames of different {what} in one folder", where=str(file.parent),
                    value=f"{files[0].name}: {here}; {file.name}: {there}",
                    limit="frames of one camera, alike in size and type",
                    remedy="put the frames of each camera into a folder of its own",
                )  # fmt: skip
        stack[index] = image
    return stack


def _size(image: np.ndarray) -> str:
    return " x ".join(str(one) for one in image.shape[::-1]) + " px"


def _natural(name: str) -> list[tuple[int, str]]:
    parts = re.split(r"([0-9]+)", name.casefold())
    return [(int(part), "") if part[:1].isdecimal() else (-1, part) for part in parts if part]


def _read_times(file: Path) -> dict[str, float]:
    table = read_table(file)
    columns = table.bases({"file": {}, "time": TIME})
    if sorted(columns) != ["file", "time"]:
        raise _bad_times(file, f"header {', '.join(table.header)}")
    names = [row[columns["file"]] for row in table.rows]
    times = dict(zip(names, table.numbers(columns["time"], TIME).tolist(), strict=True))
    if len(times) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise _bad_times(file, f"{twice} twice")
    return times


def _bad_times(file: Path, value: str) -> InputError:
    return InputError(
        "the table of times does not hold a file and a time a row", where=str(file), value=value,
        limit="a header `file,time_s`, then each file's name once and its time in seconds",
        remedy="correct the row",
    )  # fmt: skip

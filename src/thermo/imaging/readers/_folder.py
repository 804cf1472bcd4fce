"""Folders of single frames: their order, their times, and that they are of one size."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float, Shaped

from thermo.errors import InputError

TIMES: Final = "times.csv"
"""Beside single frames: columns `file` and `time_s`, a row a frame."""


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


def timed(
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


def stacked(
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


def _read_times(table: Path) -> dict[str, float]:
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (UnicodeDecodeError, OSError) as error:
        raise _bad_times(table, type(error).__name__) from error
    lines = [one for one in text.splitlines() if one.strip() and not one.startswith("#")]
    separator = next((mark for mark in ";\t" if lines and mark in lines[0]), ",")
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
    if not rows or [cell.casefold() for cell in rows[0]] != ["file", "time_s"]:
        raise _bad_times(table, f"header {rows[0] if rows else '(none)'}")
    times: dict[str, float] = {}
    for row in rows[1:]:
        try:
            name, cell = row
            time = float(cell.replace(",", ".") if separator != "," else cell)
        except ValueError:
            raise _bad_times(table, f"row {row}") from None
        if name in times:
            raise _bad_times(table, f"{name} twice")
        times[name] = time
    return times


def _bad_times(table: Path, value: str) -> InputError:
    return InputError(
        "the table of times does not hold a file and a time a row", where=str(table), value=value,
        limit="a header `file,time_s`, then each file's name once and its time in seconds",
        remedy="correct the row",
    )  # fmt: skip

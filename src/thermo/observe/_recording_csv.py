"""Recordings in CSV, for people with thermocouples: long or wide form."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from thermo.errors import InputError

from ._csv_table import LENGTH, PLAIN, TEMPERATURE, TIME, Table, read_table, split_unit
from ._recording import Recording, check_time

_AXES = {"x": LENGTH, "y": LENGTH, "z": LENGTH}
_KINDS = {"time": TIME, "temperature": TEMPERATURE, "sensor": PLAIN, **_AXES}
_LONG_POINTS = {"time", "x", "y", "z", "temperature"}
_LONG_SENSORS = {"time", "sensor", "temperature"}


def read_recording_csv(path: Path) -> Recording:
    """Read a recording from CSV; `read_recording` documents the forms.

    Raises `InputError` for columns that fit no form, a sensor without position, readings given
    twice, and whatever `Recording` refuses.
    """
    table = read_table(path)
    bases = table.bases(_KINDS)
    if set(bases) == _LONG_POINTS:
        names, points = _point_samples(table, bases)
        time, temperature = _pivot(table, bases, names)
    elif set(bases) == _LONG_SENSORS:
        found = [row[bases["sensor"]] for row in table.rows]
        order = {name: number for number, name in enumerate(dict.fromkeys(found))}
        points = _positions(table.file, tuple(order))
        names = np.asarray([order[name] for name in found])
        time, temperature = _pivot(table, bases, names)
    elif bases.get("time") == 0 and len(bases) > 1 and "temperature" not in bases:
        points, time, temperature = _wide(table)
    else:
        raise _no_form(table)
    # Rows before the start of the run show the isothermal object.
    before = time < 0
    quiet = temperature[before] if before.any() else None
    return Recording(
        points, time[~before], temperature[~before], quiet=quiet, where=str(path)
    )  # fmt: skip


def _point_samples(table: Table, bases: dict[str, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the sample number of each row, and the points in order of appearance."""
    rows = np.stack([table.numbers(bases[axis], LENGTH) for axis in "xyz"], axis=1)
    points, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rank[inverse.ravel()], points[order]


def _pivot(
    table: Table, bases: dict[str, int], sample: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Turn one row a reading into one row a frame; what no row gives is missing."""
    stamps = table.numbers(bases["time"], TIME)
    values = table.numbers(bases["temperature"], TEMPERATURE, missing=True)
    if not np.isfinite(stamps).all():
        check_time(stamps, where=f"{table.file}: time", earliest=None, least_frames=1)
    time, frame = np.unique(stamps, return_inverse=True)
    samples = int(sample.max()) + 1
    place = frame.ravel() * samples + sample
    _, first, count = np.unique(place, return_index=True, return_counts=True)
    if (count > 1).any():
        row = int(first[count > 1][0])
        raise InputError(
            "two readings of one sample at one time",
            where=f"{table.file}, line {table.lines[row]}", value=f"time {stamps[row]:g} s",
            limit="one row a sample and time", remedy="remove the repeated rows",
        )  # fmt: skip
    temperature = np.full(time.size * samples, np.nan)
    temperature[place] = values
    return time, temperature.reshape(time.size, samples)


def _wide(table: Table) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    known = _sensor_table(table.file)
    names: list[str] = []
    columns: list[np.ndarray] = []
    for column, text in enumerate(table.header[1:], start=1):
        # A header that is itself the name of a sensor carries no unit.
        name = text if text in known else split_unit(table.file, text, TEMPERATURE)[0]
        names.append(name)
        columns.append(table.numbers(column, TEMPERATURE, missing=True, named=name))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(
            f"sensor `{twice}` has two columns", where=str(table.file),
            value=", ".join(table.header), limit="one column a sensor",
            remedy="remove or rename one of the two columns",
        )  # fmt: skip
    points = _positions(table.file, tuple(names), known)
    stamps = table.numbers(0, TIME)
    time = check_time(stamps, where=f"{table.file}: time", earliest=None)
    return points, time, np.stack(columns, axis=1)


def _positions(
    file: Path, names: tuple[str, ...], known: dict[str, np.ndarray] | None = None
) -> np.ndarray:
    found = _sensor_table(file) if known is None else known
    for name in names:
        if name not in found:
            raise InputError(
                f"sensor `{name}` has no position", where=str(_sensors_file(file)),
                value=f"sensors {', '.join(found)}", limit="a row for every sensor of the data",
                remedy=f"add a row with x, y, z of `{name}`, or rename the column of the data",
            )  # fmt: skip
    return np.stack([found[name] for name in names])


def _sensors_file(file: Path) -> Path:
    return file.with_name(f"{file.stem}_sensors{file.suffix}")


def _sensor_table(file: Path) -> dict[str, np.ndarray]:
    path = _sensors_file(file)
    if not path.is_file():
        raise InputError(
            "table of the sensors is missing", where=str(path), value="no such file",
            limit="a CSV file with the columns sensor, x, y, z [m] beside the data",
            remedy=f"write {path.name}, or give the data in columns time,x,y,z,temperature",
        )  # fmt: skip
    table = read_table(path)
    bases = table.bases({"sensor": PLAIN, **_AXES})
    if set(bases) != {"sensor", "x", "y", "z"}:
        raise InputError(
            "columns are not those of a sensor table", where=str(path),
            value=", ".join(table.header), limit="the columns sensor, x, y, z",
            remedy="name them so (units as in `x_mm`)",
        )  # fmt: skip
    points = np.stack([table.numbers(bases[axis], LENGTH) for axis in "xyz"], axis=1)
    names = [row[bases["sensor"]] for row in table.rows]
    for row, name in enumerate(names):
        if name in names[:row]:
            raise InputError(
                f"sensor `{name}` stands twice", where=f"{path}, line {table.lines[row]}",
                value=name, limit="one row a sensor", remedy="remove or rename one of the rows",
            )  # fmt: skip
    return dict(zip(names, points, strict=True))


def _no_form(table: Table) -> InputError:
    return InputError(
        "columns fit no form of a recording", where=str(table.file),
        value=", ".join(table.header)[:200],
        limit="time,x,y,z,temperature; or time,sensor,temperature; or time and one column a sensor",
        remedy="rename the columns (units as in `time_s`, `x_mm`, `temperature_C`)",
    )  # fmt: skip

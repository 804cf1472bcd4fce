"""Reads a recording from any of its file types."""

from __future__ import annotations

from pathlib import Path

from thermo.errors import InputError

from ._npz import check_file, read_npz
from ._recording import Recording
from ._recording_csv import read_recording_csv


def read_recording(path: Path | str) -> Recording:
    """Read a recording from NPZ or CSV.

    **NPZ**: `points` (samples, 3) [m], on or close to the surface; `time` (frames,) [s];
    `temperature` (frames, samples) [K], NaN where missing; optional `quiet` (quiet frames,
    samples) [K], frames of the isothermal object at its initial temperature before t = 0;
    optional `valid` (frames, samples) or (samples,), false where a value must not be used.

    **CSV, long form**: one row a reading, with the columns `time,x,y,z,temperature`, or
    `time,sensor,temperature` and a table of the sensors beside it. Rows may come in any order;
    a reading that no row gives is missing.

    **CSV, wide form**: the first column is `time`, every other column is a sensor, named in its
    header; one row a frame, an empty cell where a value is missing.

    The table of the sensors of `NAME.csv` is `NAME_sensors.csv` with the columns
    `sensor,x,y,z`. Without a unit a column is SI. A unit may end a column's name, as in
    `time_ms`, `x_mm`, `temperature_C` or `TC1 [C]`: s, ms, min, h; m, cm, mm, inch; K, C, F.
    Rows with a negative time are quiet frames. Separators are comma, semicolon or tab; lines
    that start with `#` are skipped.

    Arguments:

    - `path`: a file that ends in .npz, .csv, .tsv or .txt.

    Raises `InputError` if the file is absent, damaged, of another type, or holds what
    `Recording` refuses.
    """
    file = Path(path)
    kind = file.suffix.lower()
    if kind == ".npz":
        arrays = read_npz(
            file, required=("points", "time", "temperature"), optional=("quiet", "valid")
        )
        return Recording(**arrays, where=str(file))
    if kind in (".csv", ".tsv", ".txt"):
        return read_recording_csv(file)
    check_file(file)
    raise InputError(
        "unknown type of recording", where=str(file), value=kind or "no ending",
        limit=".npz, .csv, .tsv or .txt", remedy="export the recording as NPZ or CSV",
    )  # fmt: skip

"""Writes a recording as NPZ."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ._npz import write_npz
from ._recording import Recording


def write_recording(path: Path | str, recording: Recording) -> None:
    """Write a recording as NPZ, whole or not at all; values that are not valid become NaN.

    Arguments:

    - `path`: the file, in a folder that exists.
    - `recording`: what to write; `read_recording` gives it back bit for bit.

    Raises `InputError` if the file cannot be written.
    """
    arrays = {
        "points": recording.points,
        "time": recording.time,
        "temperature": np.where(recording.valid, recording.temperature, np.nan),
    }
    if recording.quiet is not None:
        arrays["quiet"] = recording.quiet
    write_npz(Path(path), arrays)

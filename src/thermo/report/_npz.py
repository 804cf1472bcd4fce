"""Arrays as NPZ."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from thermo.observe import write_whole


def write_npz(path: Path, **arrays: Any) -> None:
    """Writes named arrays to a compressed NPZ file, whole or not at all.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `arrays`: numbers, truth values or text of any shape; JAX arrays too.

    Raises `TypeError` for an array of objects, which could only be written as a pickle.
    """
    plain = {name: np.asarray(value) for name, value in arrays.items()}
    for name, array in plain.items():
        if array.dtype.hasobject:
            raise TypeError(f"{name}: an array of objects cannot be written to {path}")
    # An open file, because NumPy would add a second suffix to a name that does not end in .npz.
    with write_whole(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **plain)

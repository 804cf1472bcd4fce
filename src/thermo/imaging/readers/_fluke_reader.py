"""IS2 files of Fluke's cameras, one or a folder of them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged, library
from ._folder import is_kind, single_frames
from ._reader import AbstractReader
from ._stated import Stated

_SUFFIXES = (".is2",)
_APART: Final = 2.0
_SHARE: Final = 0.02
"""How far the mean of what is read may be from the one that the file states, the larger of 2 K and
2 % of it in degrees Celsius: the accuracy in data sheets of these cameras, below which a difference
does not matter. A model whose file is laid out otherwise is further off."""


@final
class FlukeReader(AbstractReader):
    """IS2 of Fluke: temperatures [K] by emissivity, background and transmission in each file.

    The format is not documented; the library that reads it knows the Ti300 and the Ti480 PRO. The
    mean of each frame must be the one that the file itself states, where it does. A file has no
    time that is fine enough for frames: state `rate`, or put `times.csv` beside the files.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "IS2 of Fluke (one, or a folder of them)"

    def recognises(self, path: Path) -> bool:
        """By suffix: the file is a zip archive as many others are."""
        return is_kind(path, _SUFFIXES)

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] and their times [s]; raises `InputError`."""
        reader = library("fluke_thermal_reader", path)
        return single_frames(
            path, _SUFFIXES, lambda file: _celsius(file, reader), given, unit="C"
        )  # fmt: skip


def _celsius(path: Path, reader: Any) -> np.ndarray:
    parser = reader.IS2Parser()
    with tempfile.TemporaryDirectory() as folder:
        # By itself it unpacks into the folder that the program runs in.
        parser.temp_dir = str(Path(folder) / "unpacked")
        try:
            found = parser.parse(str(path))
        except Exception as error:  # the library lets out whatever its parsing meets
            raise damaged(path, "IS2 file", error) from error
    values = np.asarray(found["data"], np.float32)
    stated = found.get("AvgTemp", 0.0)  # 0 also where the file does not state it
    mean = float(np.nanmean(values)) if np.isfinite(values).any() else np.nan
    limit = max(_APART, _SHARE * abs(stated))
    if stated and not abs(mean - stated) <= limit:
        raise InputError(
            "the temperatures are not those that the file states", where=str(path),
            value=f"mean {mean:.1f} C, stated {stated:.1f} C", limit=f"within {limit:.3g} K",
            remedy="this camera lays its files out in a way that is not known: export TIFF or CSV "
            "from SmartView",
        )  # fmt: skip
    return values

"""Readers of what thermal cameras and their programs write, one module a format.

`thermo.imaging.read_frames` picks among them. Libraries that not everyone has are imported only
when a file of theirs is read.
"""

from __future__ import annotations

from ._closed import check_open
from ._csv_folder import CsvFolderReader
from ._dji_reader import DjiReader
from ._flir_reader import FlirReader
from ._fluke_reader import FlukeReader
from ._hcc_reader import HccReader
from ._hdf5_reader import Hdf5Reader
from ._npy_reader import NpyReader
from ._npz_reader import NpzReader
from ._reader import AbstractReader
from ._stated import Stated
from ._tiff_reader import TiffReader

__all__ = [
    "AbstractReader",
    "CsvFolderReader",
    "DjiReader",
    "FlirReader",
    "FlukeReader",
    "HccReader",
    "Hdf5Reader",
    "NpyReader",
    "NpzReader",
    "Stated",
    "TiffReader",
    "check_open",
]

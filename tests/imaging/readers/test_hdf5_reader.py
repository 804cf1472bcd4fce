"""HDF5 files of frames."""

from __future__ import annotations

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging.readers import Hdf5Reader, Stated

READER = Hdf5Reader()
KELVIN = 300.0 + np.arange(24.0).reshape(2, 3, 4)


def written(path: Path, unit: object = None, **arrays: object) -> Path:
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name] = array
        if unit is not None:
            file["frames"].attrs["unit"] = unit
    return path


@pytest.mark.parametrize("unit", ["C", b"celsius", np.bytes_("degC")])
def test_datasets_and_unit(tmp_path: Path, unit: object) -> None:
    path = written(tmp_path / "film.h5", unit, frames=KELVIN - 273.15, time=[0.0, 0.5])
    frames = READER.read(path, Stated())
    np.testing.assert_allclose(frames.values, KELVIN, atol=3e-5)
    np.testing.assert_array_equal(frames.time, [0.0, 0.5])


def test_counts_and_calendar_times(tmp_path: Path) -> None:
    raw = (KELVIN * 30).astype(np.uint16)
    path = written(tmp_path / "film.h5", frames=raw, time=[1.7e9, 1.7e9 + 2.0])
    frames = READER.read(path, Stated())
    assert frames.counts
    np.testing.assert_array_equal(frames.values, raw)
    np.testing.assert_array_equal(frames.time, [0.0, 2.0])


def test_a_file_is_known_by_its_first_bytes(tmp_path: Path) -> None:
    path = written(tmp_path / "film.dat", frames=KELVIN)
    assert READER.recognises(path)
    assert not READER.recognises(tmp_path)


@pytest.mark.parametrize(
    ("arrays", "part"),
    [
        ({"picture": KELVIN}, "arrays picture"),
        ({"frames": KELVIN[0, 0]}, "these are no frames"),
        ({"frames": np.zeros((0, 3, 4))}, "these are no frames"),
        ({"frames": [b"a", b"bc"]}, "frames"),
        ({"frames": ["a", "bc"]}, "objects"),
        ({"frames": KELVIN, "time": [0.0]}, "2 frames, 1 times"),
    ],
)
def test_wrong_contents_name_the_file(tmp_path: Path, arrays: dict, part: str) -> None:
    path = written(tmp_path / "film.h5", **arrays)
    with pytest.raises(InputError) as caught:
        READER.read(path, Stated() if "time" in arrays else Stated(rate=1.0))
    assert part in str(caught.value) and "film.h5" in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.9])
def test_truncated_files_are_refused(tmp_path: Path, share: float) -> None:
    path = written(tmp_path / "film.h5", frames=KELVIN)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match="not a whole HDF5 file"):
        READER.read(path, Stated(rate=1.0))


def test_a_missing_library_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path / "film.h5", frames=KELVIN)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"pip install 'thermofield\[cameras\]'"):
        READER.read(path, Stated(rate=1.0))

"""NumPy's files of frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging.readers import NpyReader, NpzReader, Stated

READER = NpzReader()
KELVIN = 300.0 + np.arange(24.0).reshape(2, 3, 4)


def test_arrays_are_read_by_name(tmp_path: Path) -> None:
    path = tmp_path / "film.npz"
    valid = np.ones((3, 4), bool)
    valid[0, 0] = False
    np.savez(path, frames=KELVIN - 273.15, time=[-1, 3], valid=valid, unit="C")
    frames = READER.read(path, Stated())
    np.testing.assert_allclose(frames.values, KELVIN, atol=3e-5)
    np.testing.assert_array_equal(frames.time, [-1.0, 3.0])
    np.testing.assert_array_equal(frames.valid, [valid, valid])


def test_temperature_is_kelvin_even_in_whole_numbers(tmp_path: Path) -> None:
    path = tmp_path / "film.npz"
    np.savez(path, temperature=KELVIN.astype(np.int32))
    frames = READER.read(path, Stated(rate=2.0))
    assert not frames.counts
    np.testing.assert_array_equal(frames.time, [0.0, 0.5])
    np.savez(path, frames=KELVIN.astype(np.int32))
    assert READER.read(path, Stated(rate=2.0)).counts


@pytest.mark.parametrize(
    ("arrays", "part"),
    [
        ({"image": KELVIN}, "no array of frames"),
        ({"frames": KELVIN, "temperature": KELVIN}, "two arrays"),
        ({"frames": KELVIN, "time": [0.0, 1.0, 2.0]}, "2 frames, 3 times"),
        ({"frames": KELVIN, "time": [[0.0, 1.0]]}, "not one a frame"),
        ({"frames": KELVIN, "time": [1.0, 1.0]}, "time does not increase"),
        ({"frames": KELVIN, "time": [1.0, 0.0]}, "1 s at frame 0, then 0 s"),
        ({"frames": KELVIN, "time": ["0", "1"]}, "plain numbers"),
        ({"frames": KELVIN, "unit": "F"}, "unknown unit"),
        ({"frames": KELVIN, "valid": np.full((3, 4), 0.5)}, "neither true nor false"),
        ({"frames": KELVIN, "valid": np.ones((2, 2), bool)}, "valid does not fit"),
        ({"frames": np.array([KELVIN, None], object)}, "objects"),
    ],
)
def test_wrong_contents_name_the_file(tmp_path: Path, arrays: dict, part: str) -> None:
    path = tmp_path / "film.npz"
    np.savez(path, **arrays)
    with pytest.raises(InputError) as caught:
        READER.read(path, Stated() if "time" in arrays else Stated(rate=1.0))
    assert part in str(caught.value) and "film.npz" in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("name", ["film.npz", "film.npy"])
def test_truncated_files_are_refused(tmp_path: Path, share: float, name: str) -> None:
    path = tmp_path / name
    np.savez(path, frames=KELVIN) if name.endswith("z") else np.save(path, KELVIN)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    reader = READER if name.endswith("z") else NpyReader()
    assert reader.recognises(path)
    with pytest.raises(InputError, match="truncated") as caught:
        reader.read(path, Stated(rate=1.0))
    assert name in str(caught.value)


def test_a_single_array(tmp_path: Path) -> None:
    path = tmp_path / "film.npy"
    np.save(path, KELVIN[0])
    frames = NpyReader().read(path, Stated(start=2.0))
    np.testing.assert_array_equal(frames.values[0], KELVIN[0])
    assert frames.time == [2.0]
    np.save(path, np.array([{}]), allow_pickle=True)
    with pytest.raises(InputError, match="objects, which are never loaded"):
        NpyReader().read(path, Stated())

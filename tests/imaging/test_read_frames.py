"""Which reader reads what."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
import tifffile

from thermo.errors import InputError
from thermo.imaging import _read_frames
from thermo.imaging._frames import Frames
from thermo.imaging._read_frames import GROUP, read_frames
from thermo.imaging.readers import AbstractReader, Stated

KELVIN = (300.0 + np.arange(24.0).reshape(2, 3, 4)).astype(np.float32)


def test_the_suffix_or_the_first_bytes_pick_the_reader(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", KELVIN)
    np.savez(tmp_path / "a.npz", frames=KELVIN, time=[0.0, 1.0])
    tifffile.imwrite(tmp_path / "a.bin", KELVIN, photometric="minisblack")
    for name in ("a.npy", "a.npz", "a.bin"):
        frames = read_frames(tmp_path / name, Stated(rate=1.0))
        np.testing.assert_array_equal(frames.values, KELVIN)
        np.testing.assert_array_equal(frames.time, [0.0, 1.0])


def test_nothing_there_and_empty_folders(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing there"):
        read_frames(tmp_path / "film.npz")
    with pytest.raises(InputError, match="an empty folder"):
        read_frames(tmp_path)


def test_what_no_reader_knows_gets_the_list_of_formats(tmp_path: Path) -> None:
    (tmp_path / "film.avi").write_bytes(b"RIFF")
    for path in (tmp_path / "film.avi", tmp_path):
        with pytest.raises(InputError, match="no reader knows") as caught:
            read_frames(path)
        for known in ("NPZ", "TIFF", "HDF5", "FLIR", "HCC", "CSV", GROUP, ".avi"):
            assert known in str(caught.value)


@pytest.mark.parametrize("name", ["a.is3", "a.IRB", "a.seq"])
def test_closed_formats_say_what_to_export(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"PK\x03\x04")
    for path in (tmp_path / name, tmp_path):
        with pytest.raises(InputError, match="maker's own") as caught:
            read_frames(path)
        assert "TIFF" in str(caught.value)


def test_a_folder_of_two_formats_is_refused(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "a.tif", KELVIN[0])
    (tmp_path / "a.csv").write_text("300,301\n")
    with pytest.raises(InputError, match="two formats") as caught:
        read_frames(tmp_path)
    assert "TIFF" in str(caught.value) and "CSV" in str(caught.value)


class OddReader(AbstractReader):
    def format(self) -> str:
        return "ODD"

    def recognises(self, path: Path) -> bool:
        return path.suffix == ".odd"

    def read(self, path: Path, given: Stated) -> Frames:
        return Frames([0.0], KELVIN[:1])


class OtherReader(AbstractReader):
    def format(self) -> str:
        return "OTHER"

    def recognises(self, path: Path) -> bool:
        return False

    def read(self, path: Path, given: Stated) -> Frames:
        raise AssertionError


def offered(monkeypatch: pytest.MonkeyPatch, **values: object) -> list[str]:
    """Entry points of these objects; the names of those that are loaded."""
    loaded: list[str] = []

    def load(point: EntryPoint) -> object:
        loaded.append(point.name)
        return values[point.name]

    points = [EntryPoint(name, "far.away:it", GROUP) for name in values]
    monkeypatch.setattr(EntryPoint, "load", load)
    monkeypatch.setattr(_read_frames, "entry_points", lambda group: points * (group == GROUP))
    return loaded


def test_installed_readers_are_asked_last_and_loaded_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = offered(monkeypatch, c=OtherReader, b=OddReader, a=OtherReader)
    np.save(tmp_path / "a.npy", KELVIN)
    read_frames(tmp_path / "a.npy", Stated(rate=1.0))
    assert loaded == []
    (tmp_path / "a.odd").write_bytes(b"")
    np.testing.assert_array_equal(read_frames(tmp_path / "a.odd").values, KELVIN[:1])
    assert loaded == ["a", "b"]


@pytest.mark.parametrize("wrong", [dict, None, lambda: 1 / 0])
def test_a_broken_entry_point_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: object
) -> None:
    offered(monkeypatch, bad=wrong)
    (tmp_path / "a.odd").write_bytes(b"")
    with pytest.raises(InputError, match="bad = far.away:it"):
        read_frames(tmp_path / "a.odd")

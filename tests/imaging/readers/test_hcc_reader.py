"""Telops recordings, written by the library that reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fasthcc import write_hcc

from thermo.errors import InputError
from thermo.imaging.readers import HccReader, Stated

READER = HccReader()
RAW = np.random.default_rng(1).integers(6000, 9000, (4, 8, 32)).astype(np.uint16)


def film(path: Path, mode: int = 2, stamps: bool = True, exps: tuple[int, ...] = (-8,) * 4) -> Path:
    headers = [
        {"POSIXTime": 1_700_000_000 + k // 2, "SubSecondTime": 5_000_000 * (k % 2)}
        if stamps else {} for k in range(4)
    ]  # fmt: skip
    for header, exp in zip(headers, exps, strict=True):
        header["DataExp"] = exp
    write_hcc(path, RAW, calibration_mode=mode, frame_rate=25.0, metadata=headers)
    return path


def test_temperatures_and_stamps(tmp_path: Path) -> None:
    frames = READER.read(film(tmp_path / "film.hcc"), Stated())
    np.testing.assert_allclose(frames.values, RAW / 256 + 273.15, atol=3e-5)
    np.testing.assert_allclose(frames.time, [0.0, 0.5, 1.0, 1.5], atol=1e-9)
    assert not frames.counts


def test_each_frame_has_its_own_calibration(tmp_path: Path) -> None:
    path = film(tmp_path / "film.hcc", exps=(-8, -7, -8, -8))
    values = READER.read(path, Stated()).values
    np.testing.assert_allclose(values[1], RAW[1] / 128 + 273.15, atol=3e-5)
    np.testing.assert_allclose(values[2], RAW[2] / 256 + 273.15, atol=3e-5)


def test_without_stamps_the_headers_rate_counts_unless_one_is_stated(tmp_path: Path) -> None:
    path = film(tmp_path / "film.hcc", stamps=False)
    np.testing.assert_allclose(READER.read(path, Stated()).time, np.arange(4) / 25)
    np.testing.assert_allclose(READER.read(path, Stated(rate=4.0)).time, np.arange(4) / 4)


@pytest.mark.parametrize(("mode", "unit"), [(0, None), (2, "counts")])
def test_the_stored_signal(tmp_path: Path, mode: int, unit: str | None) -> None:
    frames = READER.read(film(tmp_path / "film.hcc", mode), Stated(unit=unit))
    assert frames.counts
    np.testing.assert_array_equal(frames.values, RAW)


@pytest.mark.parametrize("cut", [10, 100, 700, 1281])
def test_truncated_and_foreign_files_are_refused(tmp_path: Path, cut: int) -> None:
    path = film(tmp_path / "film.hcc")
    whole = path.read_bytes()
    path.write_bytes(whole[:cut])
    with pytest.raises(InputError, match="not a whole HCC file"):
        READER.read(path, Stated())
    path.write_bytes(b"XX" + whole[2:])
    with pytest.raises(InputError, match="signature"):
        READER.read(path, Stated())

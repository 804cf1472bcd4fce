"""TIFF stacks and folders of TIFF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tifffile

from thermo.errors import InputError
from thermo.imaging.readers import Stated, TiffReader

READER = TiffReader()
RAW = np.random.default_rng(0).integers(29000, 31000, (4, 12, 16)).astype(np.uint16)
RATE = Stated(rate=5.0)


def write(path: Path, values: np.ndarray, **more: object) -> Path:
    tifffile.imwrite(path, values, photometric="minisblack", **more)
    return path


def test_sixteen_bits_are_counts_or_scaled(tmp_path: Path) -> None:
    path = write(tmp_path / "film.tif", RAW)
    frames = READER.read(path, RATE)
    assert frames.counts
    np.testing.assert_array_equal(frames.values, RAW)
    np.testing.assert_allclose(frames.time, [0.0, 0.2, 0.4, 0.6])
    kelvin = READER.read(path, Stated(rate=5.0, scale=0.01))
    np.testing.assert_allclose(kelvin.values, RAW * 0.01, atol=2e-5)
    celsius = READER.read(path, Stated(rate=5.0, scale=0.1, offset=-2975.0, unit="C"))
    np.testing.assert_allclose(celsius.values, RAW * 0.1 - 2975.0 + 273.15, atol=1e-4)


def test_floats_are_kelvin_or_stated_celsius(tmp_path: Path) -> None:
    path = write(tmp_path / "film.tif", (RAW * 0.01).astype(np.float32), compression="zlib")
    np.testing.assert_allclose(READER.read(path, RATE).values, RAW * 0.01, atol=2e-5)
    with pytest.raises(InputError, match="look like kelvin"):
        READER.read(path, Stated(rate=5.0, unit="C"))


def test_a_folder_in_the_order_of_its_numbers(tmp_path: Path) -> None:
    for n, image in zip((1, 2, 10, 11), RAW, strict=True):
        write(tmp_path / f"T{n}.TIFF", image)
    assert READER.recognises(tmp_path)
    np.testing.assert_array_equal(READER.read(tmp_path, RATE).values, RAW)
    write(tmp_path / "T3.tif", RAW[0, :, :10])
    with pytest.raises(InputError, match="different sizes") as caught:
        READER.read(tmp_path, RATE)
    assert "T1.TIFF: 16 x 12 px; T3.tif: 10 x 12 px" in str(caught.value)
    write(tmp_path / "T3.tif", RAW[0].astype(np.float32))
    with pytest.raises(InputError, match="T1.TIFF: uint16; T3.tif: float32"):
        READER.read(tmp_path, RATE)
    write(tmp_path / "T3.tif", RAW)
    with pytest.raises(InputError, match="different sizes"):
        READER.read(tmp_path, RATE)


def test_a_film_without_rate_is_refused_and_one_image_is_not(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing tells the times"):
        READER.read(write(tmp_path / "film.tif", RAW), Stated())
    assert READER.read(write(tmp_path / "one.tif", RAW[0]), Stated()).values.shape == (1, 12, 16)


def writers(kind: str, path: Path) -> None:
    if kind == "pages":
        with tifffile.TiffWriter(path) as file:
            for image in RAW:
                file.write(image, contiguous=False, metadata=None, photometric="minisblack")
    else:
        write(path, RAW, **({"imagej": True} if kind == "imagej" else {"compression": "zlib"}))


@pytest.mark.parametrize("kind", ["pages", "packed", "imagej"])
@pytest.mark.parametrize("share", [0.0, 0.002, 0.25, 0.5, 0.6])
def test_truncated_files_are_refused(tmp_path: Path, kind: str, share: float) -> None:
    path = tmp_path / "film.tif"
    writers(kind, path)
    np.testing.assert_array_equal(READER.read(path, RATE).values, RAW)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match="not a whole TIFF file") as caught:
        READER.read(path, RATE)
    assert "film.tif" in str(caught.value)


def test_colours_previews_and_eight_bits_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "film.tif"
    tifffile.imwrite(path, np.zeros((12, 16, 3), np.uint16), photometric="rgb")
    with pytest.raises(InputError, match="one channel"):
        READER.read(path, RATE)
    with tifffile.TiffWriter(path) as file:
        file.write(RAW[0], photometric="minisblack")
        file.write(RAW[0, ::2, ::2], photometric="minisblack")
    with pytest.raises(InputError, match="16 x 12 px; 8 x 6 px"):
        READER.read(path, RATE)
    with pytest.raises(InputError, match="eight bits"):
        READER.read(write(path, RAW.astype(np.uint8)), RATE)

"""Radiometric JPEG of FLIR, built byte by byte."""

from __future__ import annotations

import io
import math
import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import read_frames
from thermo.imaging.readers import FlirReader, Stated

READER = FlirReader()
R1, R2, B, F, OFFSET = 16000.0, 0.0125, 1430.0, 1.0, -7000


def signal(kelvin: np.ndarray | float) -> np.ndarray:
    """Planck's law as FLIR's cameras have it [1]."""
    return R1 / (R2 * (np.exp(B / np.asarray(kelvin)) - F)) - OFFSET


def camera_info(emissivity: float, reflected: float, planck_b: float) -> bytes:
    info = bytearray(900)
    struct.pack_into("<6f", info, 32, emissivity, 0.0, reflected, 293.15, 293.15, 1.0)
    struct.pack_into("<f", info, 60, 0.5)
    struct.pack_into("<3f", info, 88, R1, planck_b, F)
    struct.pack_into("<5f", info, 112, 0.0066, 0.0126, -0.0023, -0.0067, 1.9)
    struct.pack_into("<if", info, 776, OFFSET, R2)
    return bytes(info)


def radiometric(
    raw: np.ndarray,
    date: str | None = None,
    part: str | None = None,
    *,
    emissivity: float = 1.0,
    reflected: float = 293.15,
    planck_b: float = B,
    maker: str = "FLIR Systems",
) -> bytes:
    rows, columns = raw.shape
    info = camera_info(emissivity, reflected, planck_b)
    pixels = struct.pack("<3H", 2, columns, rows).ljust(32, b"\0") + raw.astype("<u2").tobytes()
    start = 64 + 32 * 8
    entries = b""
    for kind, offset, length in ((1, start, len(pixels)), (32, start + len(pixels), len(info))):
        entries += struct.pack(">HHIIII", kind, 2, 100, 1, offset, length).ljust(32, b"\0")
    head = b"FFF\0" + b"\0" * 16 + struct.pack(">3I", 100, 64, 8)
    data = head.ljust(64, b"\0") + entries.ljust(32 * 8, b"\0") + pixels + info
    app1 = b"FLIR\0\x01\0\0" + data
    segment = b"\xff\xe1" + struct.pack(">H", len(app1) + 2) + app1
    exif = Image.Exif()
    exif[0x010F] = maker
    if date is not None:
        exif.get_ifd(0x8769)[0x9003] = date
    if part is not None:
        exif.get_ifd(0x8769)[0x9291] = part
    stream = io.BytesIO()
    Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(stream, "JPEG", exif=exif)
    jpeg = stream.getvalue()
    return jpeg[:2] + segment + jpeg[2:]


def flir_data_last(jpeg: bytes) -> bytes:
    """The same picture with FLIR's data behind its other data and two full segments."""
    ends = [2]
    for _ in range(3):  # FLIR's, the file's, and the Exif data
        start = ends[-1] + 2
        ends.append(start + int.from_bytes(jpeg[start : start + 2], "big"))
    full = b"\xff\xe4\xff\xff" + bytes(0xFFFD)
    return jpeg[:2] + jpeg[ends[1] : ends[3]] + 2 * full + jpeg[2 : ends[1]] + jpeg[ends[3] :]


KELVIN = np.linspace(280.0, 340.0, 48).reshape(6, 8)


def test_kelvin_of_a_black_body(tmp_path: Path) -> None:
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(np.round(signal(KELVIN)), "2024:05:01 12:00:00"))
    frames = READER.read(path, Stated())
    np.testing.assert_allclose(frames.values[0], KELVIN, atol=0.02)
    assert frames.time == [0.0] and not frames.counts


def test_emissivity_and_reflected_temperature_of_the_file(tmp_path: Path) -> None:
    seen = 0.8 * signal(KELVIN) + 0.2 * signal(310.0)
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(np.round(seen), emissivity=0.8, reflected=310.0))
    np.testing.assert_allclose(READER.read(path, Stated()).values[0], KELVIN, atol=0.03)


def test_the_signal_as_counts(tmp_path: Path) -> None:
    raw = np.round(signal(KELVIN))
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(raw))
    frames = READER.read(path, Stated(unit="counts"))
    assert frames.counts
    np.testing.assert_array_equal(frames.values[0], raw)


def test_a_folder_by_its_dates_with_parts_of_a_second(tmp_path: Path) -> None:
    raw = np.round(signal(KELVIN))
    for n, part in ((1, "25"), (2, "500"), (10, "75")):
        (tmp_path / f"IR_{n}.jpg").write_bytes(radiometric(raw + n, "2024:05:01 12:00:59", part))
    frames = READER.read(tmp_path, Stated())
    np.testing.assert_allclose(frames.time, [0.0, 0.25, 0.5], atol=1e-6)
    got = READER.read(tmp_path, Stated(unit="counts", start=-2.0))
    np.testing.assert_array_equal(got.values[:, 0, 0] - raw[0, 0], [1, 2, 10])
    np.testing.assert_allclose(got.time, [-2.0, -1.75, -1.5], atol=1e-6)


def test_whole_seconds_that_repeat_ask_for_a_rate(tmp_path: Path) -> None:
    for n in range(3):
        content = radiometric(np.round(signal(KELVIN)), "2024:05:01 12:00:59")
        (tmp_path / f"{n}.jpg").write_bytes(content)
    with pytest.raises(InputError, match="nothing tells the times"):
        READER.read(tmp_path, Stated())
    np.testing.assert_array_equal(READER.read(tmp_path, Stated(rate=2.0)).time, [0.0, 0.5, 1.0])


def test_mixed_sizes_name_both_files(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(radiometric(np.round(signal(KELVIN))))
    (tmp_path / "b.jpg").write_bytes(radiometric(np.round(signal(KELVIN[:, :5]))))
    with pytest.raises(InputError, match="a.jpg: 8 x 6 px; b.jpg: 5 x 6 px"):
        READER.read(tmp_path, Stated(rate=1.0))


@pytest.mark.parametrize("share", [0.05, 0.2, 0.5, 0.98])
def test_truncated_files_are_refused(tmp_path: Path, share: float) -> None:
    whole = radiometric(np.round(signal(KELVIN)))
    path = tmp_path / "one.jpg"
    path.write_bytes(whole[: int(share * len(whole))])
    assert READER.recognises(path)
    with pytest.raises(InputError, match="not a whole radiometric JPEG") as caught:
        READER.read(path, Stated())
    assert "one.jpg" in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "part"),
    [
        ({"emissivity": 0.0}, "emissivity = 0"),
        ({"emissivity": 95.0}, "emissivity = 95"),
        ({"planck_b": -1.0}, "planck_b = -1"),
        ({"planck_b": math.nan}, "planck_b = nan"),
    ],
)
def test_a_wrong_radiometric_header_is_refused(tmp_path: Path, wrong: dict, part: str) -> None:
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(np.round(signal(KELVIN)), **wrong))
    with pytest.raises(InputError, match="radiometric header is wrong") as caught:
        READER.read(path, Stated())
    assert part in str(caught.value) and "one.jpg" in str(caught.value)
    assert READER.read(path, Stated(unit="counts")).counts


def test_photographs_and_djis_own_format_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("THERMOFIELD_DJI_IRP", raising=False)
    path = tmp_path / "one.jpg"
    exif = Image.Exif()
    Image.new("RGB", (8, 8)).save(path)
    with pytest.raises(InputError, match="no radiometric header"):
        READER.read(path, Stated())
    exif[0x010F] = "DJI"
    Image.new("RGB", (8, 8)).save(path, exif=exif)
    assert not READER.recognises(path)
    with pytest.raises(InputError, match="DJI Thermal Analysis Tool") as caught:
        read_frames(path, Stated())
    assert "THERMOFIELD_DJI_IRP" in str(caught.value)
    path.write_bytes(radiometric(np.round(signal(KELVIN)), maker="DJI"))
    assert read_frames(path, Stated()).values.shape == (1, 6, 8)
    path.write_bytes(flir_data_last(path.read_bytes()))
    assert read_frames(path, Stated()).values.shape == (1, 6, 8)
    path.write_bytes(b"no picture")
    with pytest.raises(InputError, match="not a whole JPEG file"):
        READER.read(path, Stated())

"""Radiometric JPEG of FLIR: bytes, temperatures, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from flir_pictures import (
    AIR,
    ALPHA,
    BETA,
    MIXTURE,
    OFFSET,
    R1,
    R2,
    WINDOW,
    B,
    F,
    radiometric,
    signal,
)
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import read_frames
from thermo.imaging.readers import FlirReader, Stated

READER = FlirReader()


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


@pytest.mark.parametrize("humidity", [0.4, 40.0])
def test_air_and_window_of_the_file(tmp_path: Path, humidity: float) -> None:
    # 40 % of the water that air holds at 30 C, 30.4 g/m3 by tables; the formula's is near that.
    wet = math.sqrt(0.4 * math.exp(1.5587 + 0.06939 * 30 - 2.7816e-4 * 900 + 6.8455e-7 * 27000))
    assert wet**2 == pytest.approx(0.4 * 30.4, rel=0.02)
    passed = [math.exp(-3.0 * (a + b * wet)) for a, b in zip(ALPHA, BETA, strict=True)]
    air = MIXTURE * passed[0] + (1 - MIXTURE) * passed[1]
    assert 0.9 < air < 0.99
    seen = 0.9 * (air * signal(KELVIN) + (1 - air) * signal(AIR)) + 0.1 * signal(WINDOW)
    path = tmp_path / "one.jpg"
    told = {"distance": 9.0, "humidity": humidity, "window": 0.9}
    path.write_bytes(radiometric(np.round(seen), **told))
    np.testing.assert_allclose(READER.read(path, Stated()).values[0], KELVIN, atol=0.03)


@pytest.mark.parametrize("png", [False, True])
@pytest.mark.parametrize("order", ["<", ">"])
def test_both_orders_of_bytes_in_numbers_and_in_png(tmp_path: Path, order: str, png: bool) -> None:
    raw = np.round(signal(KELVIN))
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(raw, order=order, png=png, emissivity=0.9))
    np.testing.assert_array_equal(READER.read(path, Stated(unit="counts")).values[0], raw)
    truth = signal(293.15) + (raw - signal(293.15)) / 0.9
    kelvin = B / np.log(R1 / (R2 * (truth + OFFSET)) + F)
    np.testing.assert_allclose(READER.read(path, Stated()).values[0], kelvin, atol=1e-3)


def test_temperatures_beyond_the_camera_s_range_are_missing(tmp_path: Path) -> None:
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(np.round(signal(KELVIN)), limits=(330.0, 290.0)))
    frames = READER.read(path, Stated())
    inside = (KELVIN > 290.0) & (KELVIN < 330.0)
    assert 0.5 < inside.mean() < 0.9
    np.testing.assert_array_equal(np.isfinite(frames.values[0]), inside)
    np.testing.assert_array_equal(frames.valid[0], inside)


def test_data_in_several_segments_in_any_order(tmp_path: Path) -> None:
    raw = np.round(signal(KELVIN))
    path = tmp_path / "one.jpg"
    path.write_bytes(radiometric(raw, parts=(2, 0, 1), of=3))
    np.testing.assert_array_equal(READER.read(path, Stated(unit="counts")).values[0], raw)
    for parts, said in (((0, 2), "2 of 3 parts"), ((0, 1, 1, 2), "part 1 of FLIR's data twice")):
        path.write_bytes(radiometric(raw, parts=parts, of=3))
        with pytest.raises(InputError, match=said):
            READER.read(path, Stated())


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
        ({"window": 0.0}, "window_transmission = 0"),
        ({"distance": 1e30}, "transmission of the air = "),
        ({"distance": 3.0, "humidity": math.inf}, "transmission of the air = nan"),
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

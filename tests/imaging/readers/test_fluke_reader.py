"""IS2 files, built byte by byte as the library expects them."""

from __future__ import annotations

import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging import Stated, read_frames

pytest.importorskip("fluke_thermal_reader", reason="the extra thermofield[cameras] is missing")

# Counts are a T^2 + b T + c of degrees Celsius.
A, B, C = 0.01, 20.0, 1000.0
SIZE = (6, 4)
CELSIUS = 20.0 + np.arange(24.0).reshape(4, 6)


def write_is2(
    path: Path, celsius: np.ndarray, emissivity: float = 1.0, mean: float | None = None
) -> None:
    counts = np.round(A * celsius**2 + B * celsius + C).astype("<u2")
    curve = bytearray(24)
    for at, value in ((0, -20.0), (5, 150.0), (10, C), (15, B), (20, A)):
        curve[at : at + 4] = struct.pack("<f", value)
    calibration = bytes(20) + bytes((74, 25, 13)) + bytes(curve) + bytes(8)
    about = bytearray(60)
    for at, value in ((33, emissivity), (38, 20.0), (43, 1.0)):
        about[at : at + 4] = struct.pack("<f", value)
    wide, high = celsius.shape[::-1]
    properties = {
        "IRPROP_IR_SENSOR_WIDTH": wide, "IRPROP_IR_SENSOR_HEIGHT": high,
        "IRPROP_THERMAL_IMAGE_EMISSIVITY": emissivity, "IRPROP_THERMAL_IMAGE_BG_TEMP_C": 20.0,
        "IRPROP_THERMAL_IMAGE_AVG_TEMP_C": float(celsius.mean()) if mean is None else mean,
    }  # fmt: skip
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("CalibrationData.gpbenc", calibration)
        archive.writestr("ImageProperties.json", json.dumps(properties))
        archive.writestr("Images/Main/IRImageInfo.gpbenc", bytes(about))
        archive.writestr("Images/Main/IR.data", bytes(2 * wide) + counts.tobytes())


def test_a_folder_of_files_is_read_in_kelvin(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "shots"
    folder.mkdir()
    for number in (1, 2, 10):
        write_is2(folder / f"IR{number}.is2", CELSIUS + number)
    frames = read_frames(folder, Stated(rate=2.0))
    np.testing.assert_allclose(frames.time, [0.0, 0.5, 1.0])
    # A count is a twentieth of a degree.
    for image, number in zip(frames.values, (1, 2, 10), strict=True):
        np.testing.assert_allclose(image, CELSIUS + number + 273.15, atol=0.03)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["shots"], "nothing is left behind"


def test_the_file_s_emissivity_counts(tmp_path: Path) -> None:
    path = tmp_path / "a.is2"
    true = ((CELSIUS + 273.15) ** 4 - 0.2 * 293.15**4) / 0.8
    write_is2(path, CELSIUS, emissivity=0.8, mean=float((true**0.25 - 273.15).mean()))
    found = read_frames(path, Stated()).values[0]
    np.testing.assert_allclose(found, true**0.25, atol=0.05)


def test_what_the_file_states_otherwise_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.is2"
    write_is2(path, CELSIUS, mean=60.0)
    with pytest.raises(InputError, match="stated 60.0 C") as caught:
        read_frames(path, Stated())
    assert "a.is2" in str(caught.value)


def test_the_stated_mean_may_be_off_by_a_camera_s_accuracy(tmp_path: Path) -> None:
    """2 K, or 2 % of what is stated in Celsius where that is more."""
    path = tmp_path / "a.is2"
    for celsius, near, far in ((CELSIUS, 1.8, 2.3), (CELSIUS + 105.0, 2.5, 3.1)):
        mean = float(celsius.mean())
        write_is2(path, celsius, mean=mean + near)
        np.testing.assert_allclose(
            read_frames(path, Stated()).values[0], celsius + 273.15, atol=0.1
        )
        write_is2(path, celsius, mean=mean + far)
        with pytest.raises(InputError, match="not those that the file states"):
            read_frames(path, Stated())


def test_a_truncated_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.is2"
    write_is2(path, CELSIUS)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InputError, match="not a whole IS2 file"):
        read_frames(path, Stated())

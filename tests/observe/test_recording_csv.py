"""Recordings from CSV in long and wide form, with units, gaps and quiet frames."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from thermo.errors import InputError
from thermo.observe import read_recording

SENSORS = "sensor,x,y,z\nTC1,0,0,0\nTC2,0.0127,0,0\nspare,1,1,1\n"
SAMPLES = st.integers(1, 4)
KELVIN = st.floats(150.0, 5000.0) | st.just(np.nan)


def cell(number: float) -> str:
    """Write a number exactly; a missing one is an empty cell."""
    return "" if np.isnan(number) else repr(float(number))


@st.composite
def tables(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw distinct points, increasing times and temperatures with gaps."""
    samples, frames = draw(SAMPLES), draw(st.integers(2, 5))
    points = draw(hnp.arrays(float, (samples, 3), elements=st.floats(-1, 1, allow_subnormal=False)))
    points[:, 0] = np.arange(samples) + 0.25
    time = np.cumsum(draw(hnp.arrays(float, frames, elements=st.floats(1e-2, 1e2))))
    temperature = draw(hnp.arrays(float, (frames, samples), elements=KELVIN))
    temperature[[0, -1], 0] = 300.0
    return points, time, temperature


def check(path: Path, points: np.ndarray, time: np.ndarray, temperature: np.ndarray) -> None:
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.points, points)
    np.testing.assert_array_equal(recording.time, time)
    np.testing.assert_array_equal(recording.valid, ~np.isnan(temperature))
    kept = np.where(recording.valid, recording.temperature, np.nan)
    np.testing.assert_array_equal(kept, temperature)


@settings(max_examples=40, deadline=None)
@given(tables(), st.randoms(use_true_random=False))
def test_long_form_in_any_order(drawn, random) -> None:
    points, time, temperature = drawn
    rows = [
        f"{cell(t)},{','.join(map(cell, point))},{cell(temperature[i, j])}"
        for i, t in enumerate(time)
        for j, point in enumerate(points)
    ]
    head, tail = rows[: len(points)], rows[len(points) :]  # the first frame orders the samples
    random.shuffle(tail)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "run.csv"
        path.write_text("\n".join(["time,x,y,z,temperature", *head, *tail]))
        check(path, points, time, temperature)


@settings(max_examples=40, deadline=None)
@given(tables())
def test_long_form_with_sensors_leaves_gaps_missing(drawn) -> None:
    points, time, temperature = drawn
    rows = [
        f"s{j},{cell(t)},{cell(temperature[i, j])}"
        for j in range(len(points))
        for i, t in enumerate(time)
        if j == 0 or i == 0 or not np.isnan(temperature[i, j])
    ]
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "run.csv"
        path.write_text("\n".join(["Sensor,Time,Temperature", *rows]))
        write_sensors(path, points)
        check(path, points, time, temperature)


@settings(max_examples=40, deadline=None)
@given(tables(), st.sampled_from([",", ";", "\t"]))
def test_wide_form(drawn, separator: str) -> None:
    points, time, temperature = drawn
    lines = [separator.join(["time", *(f"s{j}" for j in range(len(points)))])]
    lines += [
        separator.join([cell(t), *map(cell, row)]) for t, row in zip(time, temperature, strict=True)
    ]
    if len(points) == 1:
        lines[2:-1] = [line.rstrip(separator) + separator for line in lines[2:-1]]
        lines[2:-1] = [
            separator.join([cell(t), cell(row[0]) or "nan"])
            for t, row in zip(time[1:-1], temperature[1:-1], strict=True)
        ]
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "run.csv"
        path.write_text("# thermocouples\n\n" + "\n".join(lines) + "\n\n")
        write_sensors(path, points)
        check(path, points, time, temperature)


def write_sensors(path: Path, points: np.ndarray) -> None:
    rows = [f"s{j},{','.join(map(cell, point))}" for j, point in enumerate(points)]
    path.with_name("run_sensors.csv").write_text("\n".join(["sensor,x,y,z", *rows]))


def test_units_in_the_header_are_converted(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(
        "time_min,x_mm,y_cm,z_inch,temperature_C\n0,10,1,1,20\n1,10,1,1,30\n2,10,1,1,40\n"
    )
    recording = read_recording(tmp_path / "run.csv")
    np.testing.assert_allclose(recording.points, [[0.01, 0.01, 0.0254]], rtol=1e-14)
    np.testing.assert_allclose(recording.time, [0.0, 60.0, 120.0])
    np.testing.assert_allclose(recording.temperature[:, 0], [293.15, 303.15, 313.15])


def test_wide_units_decimal_commas_and_blank_rows(tmp_path: Path) -> None:
    (tmp_path / "run_sensors.csv").write_text(
        "sensor;x [mm];y [mm];z [mm]\nTC1;0;0;0\nT_C;12,7;0;0"
    )
    (tmp_path / "run.csv").write_text("time (ms);TC1 [°C];T_C\n0;20,5;300,5\n500;68;301\n;;\n")
    recording = read_recording(tmp_path / "run.csv")
    np.testing.assert_allclose(recording.points[1], [0.0127, 0, 0])
    np.testing.assert_allclose(recording.time, [0.0, 0.5])
    # `T_C` is the name of a sensor, so its C is no unit.
    np.testing.assert_allclose(recording.temperature, [[293.65, 300.5], [341.15, 301.0]])


def test_fahrenheit(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("time,x,y,z,temperature_F\n0,0,0,0,32\n1,0,0,0,212\n")
    found = read_recording(tmp_path / "run.csv").temperature[:, 0]
    np.testing.assert_allclose(found, [273.15, 373.15])


def test_rows_before_the_start_are_quiet_frames(tmp_path: Path) -> None:
    (tmp_path / "run_sensors.csv").write_text(SENSORS)
    (tmp_path / "run.csv").write_text("time,TC2,TC1\n-2,295,296\n-1,295.5,\n0,300,301\n1,302,303\n")
    recording = read_recording(tmp_path / "run.csv")
    np.testing.assert_array_equal(recording.time, [0.0, 1.0])
    np.testing.assert_array_equal(recording.quiet, [[295, 296], [295.5, np.nan]])
    np.testing.assert_array_equal(recording.points[:, 0], [0.0127, 0.0])


LONG = "time,x,y,z,temperature\n"
WIDE = "time,TC1,TC2\n"
BAD = {
    "celsius": (LONG + "0,0,0,0,20\n1,0,0,0,21\n", None, ": temperature", "2 of 2 values",
                "150 to 5000 K", "273.15"),
    "infinite": (LONG + "0,0,0,0,300\n1,0,0,0,inf\n", None, ": temperature", "at frame 1",
                 "NaN where", "valid"),
    "not_a_number": (LONG + "0,0,0,0,300\n1,0,0,0,warm\n", None, ", line 3", "'warm'", "a number",
                     "correct the cell"),
    "position_missing": (LONG + "0,0,,0,300\n1,0,0,0,301\n", None, ", line 2", "''", "a number",
                         "correct the cell"),
    "position_nan": (LONG + "0,nan,0,0,300\n1,nan,0,0,301\n", None, ": points", "nan",
                     "finite metres", "drop"),
    "time_nan": (LONG + "0,0,0,0,300\nnan,0,0,0,301\n", None, ": time", "nan at frame 1", "finite",
                 "drop"),
    "read_twice": (LONG + "0,0,0,0,300\n0,0,0,0,301\n1,0,0,0,301\n", None, ", line 2", "time 0 s",
                   "one row", "repeated"),
    "one_frame": (LONG + "0,0,0,0,300\n0,1,0,0,300\n", None, ": time", "1 frames", "at least 2",
                  "record"),
    "ragged": (LONG + "0,0,0,0,300\n1,0,0,301\n", None, ", line 3", "4 cells", "5 cells", "fill"),
    "no_header": ("0,0,0,0,300\n1,0,0,0,301\n", None, "bad.csv", "0, 0, 0", "column names",
                  "time,x,y,z"),
    "header_alone": (LONG, None, "bad.csv", "1 lines", "at least one row", "export"),
    "empty": ("", None, "bad.csv", "0 lines", "at least one row", "export"),
    "binary": (b"\xff\xfe\x00\x01", None, "bad.csv", "UnicodeDecodeError", "UTF-8", "export"),
    "columns": ("time,x,y,temperature\n0,0,0,300\n", None, "bad.csv", "time, x, y",
                "time,x,y,z,temperature", "rename"),
    "no_time": ("a,b\n0,300\n", None, "bad.csv", "a, b", "time and one column", "rename"),
    "column_twice": (LONG.replace("y", "x") + "0,0,0,0,300\n", None, "bad.csv", "time, x, x",
                     "once", "rename"),
    "unit": ("time,x,y,z,temperature [R]\n0,0,0,0,300\n", None, "bad.csv", "temperature [R]",
             "degc", "convert"),
    "wide_order": (WIDE + "0,300,300\n2,300,300\n1,300,300\n", SENSORS, ": time",
                   "2 s at frame 1, then 1 s", "increasing", "sort"),
    "wide_sensors_twice": ("time,TC1_C,TC1_K\n0,20,300\n1,20,300\n", SENSORS, "bad.csv",
                           "TC1_C, TC1_K", "one column", "rename"),
    "sensors_absent": (WIDE + "0,300,300\n", None, "bad_sensors.csv", "no such file",
                       "sensor, x, y, z", "write bad_sensors.csv"),
    "sensor_without_place": ("time,TC1,TC9\n0,300,300\n", SENSORS, "bad_sensors.csv",
                             "TC1, TC2, spare", "every sensor", "TC9"),
    "long_without_place": ("time,sensor,temperature\n0,TC7,300\n", SENSORS, "bad_sensors.csv",
                           "TC1, TC2", "every sensor", "TC7"),
    "sensor_columns": (WIDE + "0,300,300\n", "sensor,x,y\nTC1,0,0\n", "bad_sensors.csv",
                       "sensor, x, y", "sensor, x, y, z", "name them"),
    "sensor_twice": (WIDE + "0,300,300\n", SENSORS + "TC1,0,0,1\n", "bad_sensors.csv, line 5",
                     "TC1", "one row", "rename"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_csv_is_refused(case, tmp_path, refuses) -> None:
    text, sensors, where, value, limit, remedy = BAD[case]
    path = tmp_path / "bad.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    if sensors is not None:
        (tmp_path / "bad_sensors.csv").write_text(sensors)
    error = refuses(
        lambda: read_recording(path), where=where, value=value, limit=limit, remedy=remedy
    )
    assert str(tmp_path) in error.where


@settings(max_examples=150, deadline=None)
@given(st.text(st.sampled_from("time,xyz\n01.-;\t\"'eTC_[]()# ") | st.characters(), max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "any.csv"
        path.write_bytes(text.encode("utf-8", errors="replace"))
        with pytest.raises(InputError) as caught:
            read_recording(path)
        assert "any" in caught.value.where

"""Folders of single frames, by CSV files; their order, times and sizes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging.readers import CsvFolderReader, Stated
from thermo.imaging.readers._folder import _natural

READER = CsvFolderReader()
RATE = Stated(rate=1.0)


def write(folder: Path, texts: dict[str, str]) -> Path:
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@given(st.lists(st.integers(0, 10**6), unique=True, min_size=2))
def test_numbers_in_names_count_as_numbers(numbers: list[int]) -> None:
    names = [f"Frame_{n}.csv" for n in numbers]
    assert sorted(names, key=_natural) == [f"Frame_{n}.csv" for n in sorted(numbers)]


def test_frame_2_comes_before_frame_10(tmp_path: Path) -> None:
    write(tmp_path, {f"frame{n}.csv": f"{290 + n},300\n301,302\n" for n in (1, 2, 10)})
    frames = READER.read(tmp_path, RATE)
    np.testing.assert_array_equal(frames.values[:, 0, 0], [291.0, 292.0, 300.0])
    np.testing.assert_array_equal(frames.time, [0.0, 1.0, 2.0])
    assert frames.size() == (2, 2)


@pytest.mark.parametrize(
    "text", ["25,5;26\n27;28\n", "25,5\t26\n27\t28\n", "25.5,26\n27,28\n", "25.5,26,\n27,28,\n"]
)
def test_separators_and_decimal_commas(tmp_path: Path, text: str) -> None:
    write(tmp_path, {"a.csv": "# T in C\n\n" + text})
    values = READER.read(tmp_path, Stated(unit="C")).values[0]
    np.testing.assert_allclose(values, np.array([[25.5, 26], [27, 28]]) + 273.15, atol=3e-5)


def test_an_empty_cell_is_missing(tmp_path: Path) -> None:
    write(tmp_path, {"a.csv": "300,,301\n300,n/a,301\n,,\n"})
    frames = READER.read(tmp_path, Stated())
    np.testing.assert_array_equal(
        frames.valid[0], [[True, False, True], [True, False, True], [False] * 3]
    )


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("300,301\n302,hot\n", "line 2"),
        ("300,301\n302\n", "1 cells"),
        ("", "no rows"),
        ("nan,nan\nnan,nan\n", "without any value"),
    ],
)
def test_bad_files_are_named_with_their_line(tmp_path: Path, text: str, part: str) -> None:
    write(tmp_path, {"a.csv": "300,301\n302,303\n", "b.csv": text})
    with pytest.raises(InputError) as caught:
        READER.read(tmp_path, RATE)
    assert part in str(caught.value) and "b.csv" in str(caught.value)


def test_mixed_sizes_name_both_files(tmp_path: Path) -> None:
    write(tmp_path, {"a.csv": "300,301,302\n", "b.csv": "300,301\n"})
    with pytest.raises(InputError, match="different sizes") as caught:
        READER.read(tmp_path, RATE)
    assert "a.csv: 3 x 1 px; b.csv: 2 x 1 px" in str(caught.value)


def test_a_table_of_times_orders_frames(tmp_path: Path) -> None:
    write(tmp_path, {"z.csv": "300\n", "a.csv": "301\n", ".hidden.csv": "x"})
    write(tmp_path, {"times.csv": "file,time_s\na.csv,2.5\nz.csv,-1\n"})
    frames = READER.read(tmp_path, Stated())
    np.testing.assert_array_equal(frames.time, [-1.0, 2.5])
    np.testing.assert_array_equal(frames.values[:, 0, 0], [300.0, 301.0])


def test_a_first_line_of_missing_cells_does_not_hide_the_separator(tmp_path: Path) -> None:
    write(tmp_path, {"a.csv": "\t\n25,5\t26\n"})
    values = READER.read(tmp_path, Stated(unit="C")).values[0]
    np.testing.assert_allclose(values[1], [298.65, 299.15], atol=3e-5)
    assert np.isnan(values[0]).all()


@pytest.mark.parametrize(
    "table", ["File;Time [ms]\nb.csv;1500,5\na.csv;500\n", "time,file\n1.5005,b.csv\n0.5,a.csv\n"]
)
def test_a_table_of_times_is_a_table_as_any_other(tmp_path: Path, table: str) -> None:
    write(tmp_path, {"a.csv": "300\n", "b.csv": "301\n", "times.csv": table})
    np.testing.assert_allclose(READER.read(tmp_path, Stated()).time, [0.5, 1.5005])


@pytest.mark.parametrize(
    ("table", "part"),
    [
        ("file,time_s\na.csv,0\n", "b.csv"),
        ("file,time_s\na.csv,0\nb.csv,1\nc.csv,2\n", "c.csv"),
        ("file,time_s\na.csv,0\na.csv,1\n", "twice"),
        ("name,t\na.csv,0\n", "header"),
        ("file,time_s\na.csv,now\nb.csv,1\n", "now"),
        ("file,time_s\na.csv,1\nb.csv,1\n", "time does not increase"),
        ("file,time_s\na.csv,1\nb.csv,nan\n", "time is not finite"),
    ],
)
def test_a_wrong_table_of_times_is_refused(tmp_path: Path, table: str, part: str) -> None:
    write(tmp_path, {"a.csv": "300\n", "b.csv": "301\n", "times.csv": table})
    with pytest.raises(InputError) as caught:
        READER.read(tmp_path, Stated())
    assert part in str(caught.value) and str(tmp_path) in str(caught.value)

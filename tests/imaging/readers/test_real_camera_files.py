"""What `benchmarks/real_camera_files.py` says of files, and real ones where a folder is named."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from flir_pictures import OFFSET, R1, R2, B, F, radiometric, signal

FOLDER = os.environ.get("THERMOFIELD_CAMERA_FILES")


@pytest.fixture(scope="module")
def benchmark() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path(__file__).parents[3] / "benchmarks"))
        yield importlib.import_module("real_camera_files")


def test_a_picture_is_compared_with_what_another_program_exported(
    tmp_path: Path, benchmark: ModuleType
) -> None:
    raw = np.round(signal(np.linspace(280.0, 340.0, 48).reshape(6, 8)))
    kelvin = B / np.log(R1 / (R2 * (raw + OFFSET)) + F)
    (tmp_path / "one.jpg").write_bytes(radiometric(raw, limits=(400.0, 285.0)))
    celsius = np.maximum(kelvin, 284.995) - 273.15
    celsius[3, 3] += 0.25
    text = "\n".join(";".join(f"{one:.4f}" for one in row) for row in celsius)
    (tmp_path / "one.csv").write_text(text.replace(".", ","), "utf-8-sig")
    (tmp_path / "two.jpg").write_bytes(b"no picture")
    row = benchmark.row_of(tmp_path / "one.jpg", tmp_path)
    assert row["camera"] == "FLIR Systems" and row["rows"] == 6 and row["columns"] == 8
    cold = int((kelvin < 285.0).sum())
    assert row["missing"] == cold > 0 and row["compared"] == 48 - cold and row["unlike"] == 0
    assert float(row["largest_difference_K"]) == pytest.approx(0.25, abs=1e-3)
    refused = benchmark.row_of(tmp_path / "two.jpg", tmp_path)
    assert "not a whole JPEG file" in refused["refused"]
    assert benchmark.summary([row, refused]).startswith("1 of 2 files read, 1 compared")


@pytest.mark.skipif(
    FOLDER is None,
    reason="THERMOFIELD_CAMERA_FILES names no folder of cameras' own files; see "
    "benchmarks/real_camera_files.py",
)
def test_real_files_give_what_flir_tools_exports(benchmark: ModuleType) -> None:
    folder = Path(str(FOLDER))
    files = [one for one in sorted(folder.rglob("*.jpg")) if one.with_suffix(".csv").is_file()]
    assert files
    for file in files:
        row = benchmark.row_of(file, folder)
        assert row["refused"] == "" and row["unlike"] == 0, row
        # Exports are rounded to a thousandth; single precision adds some hundred-thousandths.
        assert float(str(row["largest_difference_K"])) < 6e-4, row

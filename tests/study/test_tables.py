"""Tables of a study stand beside the paper's numbers."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from thermo.study import write_tables

from .records import SEEDS, STARTS, held_out, made, repeated


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open() as stream:
        return list(csv.DictReader(stream))


def test_the_tables_of_the_paper(tmp_path: Path) -> None:
    records = [made("bunny-cooling"), made("car-heating", held_out=held_out(0.01))]
    text = write_tables(tmp_path, records)
    found = rows_of(tmp_path / "recovery.csv")
    assert [row["paper error"] for row in found] == ["0.207", "0.147"]
    found = rows_of(tmp_path / "transfer.csv")
    assert [(row["test"], row["paper spatial mae"]) for row in found] == [
        ("warming", "0.485"), ("heating", "1.505"),
    ]  # fmt: skip
    assert "bunny-cooling" in text and "1.505" in text
    page = (tmp_path / "tables.md").read_text().splitlines()
    assert page[0].startswith("| scene |") and page[2].startswith("| bunny-cooling | best | none |")
    assert {line.count("|") for line in page[:4]} == {len(page[0].split("|")) - 1}
    # A part that was not studied leaves no table.
    assert {file.name for file in tmp_path.iterdir()} == {
        "recovery.csv", "transfer.csv", "tables.md",
    }  # fmt: skip


def test_a_row_without_an_expectation_has_a_gap(tmp_path: Path) -> None:
    guess = made("bunny-cooling", preset="prior")
    del guess["expected"], guess["informed"]
    write_tables(tmp_path, [guess])
    (row,) = rows_of(tmp_path / "recovery.csv")
    assert row["expected"] == "" and row["error"] == "0.01"


def test_one_process_stands_beside_the_other_and_both(tmp_path: Path) -> None:
    records = [
        made("cube-heating", error=0.02, held_out=held_out(0.3)),
        made("cube-cooling", error=0.01),
        made("cube-cooling", preset="paper", error=0.5),
        made("bear-cooling"),
        made("cube-joint", part="processes", error=0.005),
    ]
    write_tables(tmp_path, records)
    found = rows_of(tmp_path / "processes.csv")
    assert [(row["scene"], row["error"]) for row in found] == [
        ("cube-cooling", "0.01"), ("cube-heating", "0.02"), ("cube-joint", "0.005"),
    ]  # fmt: skip
    assert [row["heating mae [K]"] for row in found] == ["", "0.3", ""]
    assert "cube-joint" not in (tmp_path / "recovery.csv").read_text()


def test_width_against_weight(tmp_path: Path) -> None:
    write_tables(tmp_path, [made("car-heating", part="smoothness", step=0.1, width=0.04)])
    (row,) = rows_of(tmp_path / "smoothness.csv")
    assert (row["step"], row["weight"], row["width"]) == ("0.1", "100", "0.04")


def test_repeated_fits_are_one_row(tmp_path: Path) -> None:
    lone = made("bear-cooling", part="ensembles")
    write_tables(tmp_path, [*repeated("car-cooling"), *repeated("cube-heating"), lone])
    car, cube = rows_of(tmp_path / "ensembles.csv")
    assert (car["fits"], car["ratio"], car["paper ratio"]) == ("4", "1", "0.791")
    logs = 0.005 * np.log10(np.repeat(STARTS, len(SEEDS)))
    assert float(car["deviation"]) == pytest.approx(logs.std(ddof=1), rel=1e-3)
    # All of the scatter comes from the starts.
    assert float(car["share of start"]) == 1.0 and cube["paper ratio"] == ""

"""A study: many cases one after the other, taken up where it stopped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from thermo.study._case import Case
from thermo.study._case_study import study_case
from thermo.study._figures import write_figures
from thermo.study._tables import write_tables

Watch = Callable[[int], object]
"""Told how many cases are done."""


def study(
    cases: Sequence[Case], folder: Path, *, on_case: Watch
) -> tuple[list[dict[str, Any]], str]:
    """Run cases one after the other; returns their records [SI] and their tables as text.

    Each case leaves a JSON file in `folder`, and the tables are written anew after each, so that
    an interrupted study goes on with the case where it stopped. The figures are drawn at the end.
    """
    records, text = [], ""
    for case in cases:
        records.append(study_case(case, folder))
        text = write_tables(folder, records)
        on_case(len(records))
    write_figures(folder, records)
    return records, text

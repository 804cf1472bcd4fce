"""A study: many rows under several presets, one after the other, taken up where it stopped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from thermo.errors import InputError
from thermo.study._paper import QUICK_ROWS, ROWS
from thermo.study._preset import PRESETS
from thermo.study._row_study import Case, study_row
from thermo.study._tables import write_tables

QUICK_NODES = 3000
"""About the most nodes [1] of the meshes of a quick study."""

NOISES = ("none", "camera")

Watch = Callable[[int], object]
"""Told how many cases are done."""


def paper_cases(
    data: Path,
    *,
    rows: Sequence[str] | None,
    presets: Sequence[str],
    noises: Sequence[str],
    size: Literal["quick", "full"],
    cache: Path | None = None,
) -> list[Case]:
    """The cases of the paper's tables 1 and 2.

    Arguments:

    - `data`: folder that holds the scenes.
    - `rows`: such as `cube-cooling`, None for all of the size.
    - `presets`, `noises`: names; `size`: "quick" takes few rows and coarse meshes.
    - `cache`: folder of meshes, None for the user's.

    Raises `InputError` for names that there are not, and where a scene is missing.
    """
    rows = rows or (QUICK_ROWS if size == "quick" else tuple(ROWS))
    for what, given, known in (
        ("rows", rows, tuple(ROWS)),
        ("presets", presets, tuple(PRESETS)),
        ("noise", noises, NOISES),
    ):
        wrong = [name for name in given if name not in known]
        if wrong or not given:
            raise InputError(
                "a study does not know this name", where=what, value=", ".join(wrong) or "none",
                limit=", ".join(known), remedy=f"give {what}=[{known[0]}], for example",
            )  # fmt: skip
    for name in rows:
        folder = data / ROWS[name].object
        if not (folder / "scene.json").is_file():
            raise InputError(
                "a scene of the study is missing", where="data", value=str(folder),
                limit="a folder for each object, with its scene.json",
                remedy="give data=FOLDER, the folder that holds the scenes, or fewer rows=[...]",
            )  # fmt: skip
    nodes = {"max_nodes": QUICK_NODES} if size == "quick" else {}
    made = {
        name: replace(PRESETS[name], meshing=replace(PRESETS[name].meshing, cache=cache, **nodes))
        for name in presets
    }
    return [
        Case(ROWS[row], name, preset, data, noise == "camera", size == "full")
        for noise in noises
        for name, preset in made.items()
        for row in rows
    ]


def study(
    cases: Sequence[Case], folder: Path, *, on_case: Watch
) -> tuple[list[dict[str, Any]], str]:
    """Run cases one after the other; returns their records [SI] and their tables as text.

    Each case leaves a JSON file in `folder`, and the tables are written anew after each, so that
    an interrupted study goes on with the case where it stopped.
    """
    records, text = [], ""
    for case in cases:
        records.append(study_row(case, folder))
        text = write_tables(folder, records)
        on_case(len(records))
    return records, text

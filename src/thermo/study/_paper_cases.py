"""Which fits the paper's tables and figures ask for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Literal, get_args

from thermo.errors import InputError
from thermo.inverse import Uniform
from thermo.study._case import Case, Part
from thermo.study._paper import QUICK_ROWS, REPEATED, ROWS, joint_row
from thermo.study._preset import PRESETS, Preset

QUICK_NODES = 3000
"""About the most nodes [1] of the meshes of a quick study."""

NOISES = ("none", "camera")
PARTS: tuple[Part, ...] = get_args(Part)
Size = Literal["quick", "full"]

STARTS = {"full": (0.1, 0.5, 2.0, 10.0), "quick": (0.3, 3.0)}
SEEDS = {"full": (0, 1, 2, 3), "quick": (0, 1)}
"""First values, as factors [1], and seeds of the repeated fits."""

STEPS = {"full": (0.01, 0.03, 0.1, 0.3, 1.0, 10.0), "quick": (0.1, 10.0)}
"""Smoothness [1] of the ablation; the last is as good as none."""

ABLATED = ("bunny-cooling", "car-heating")
"""Rows of the ablation: a poor conductor and a good one, without a lamp and with it."""


def paper_cases(
    data: Path,
    *,
    parts: Sequence[str] | None,
    rows: Sequence[str] | None,
    presets: Sequence[str],
    noises: Sequence[str],
    size: Size,
    cache: Path | None = None,
) -> list[Case]:
    """The cases of the paper's tables and figures.

    Arguments:

    - `parts`: `tables` 1 and 2, `processes` (cooling, heating and both at once), `smoothness`
      (width against the weight of the prior), `ensembles` (figure 3). None takes all, or the
      tables where `size` is "quick".
    - `rows`: such as `cube-cooling`, None for those of each part.
    - `presets`, `noises`: names; `size`: "quick" takes few rows and coarse meshes.
    - `cache`: folder of meshes, None for the user's.

    Fields that cannot vary are left out of all parts but the tables. Raises `InputError` for names
    that there are not, where nothing is left to do, and where a scene is missing.
    """
    picked = (PARTS if size == "full" else PARTS[:1]) if parts is None else parts
    for what, given, known in (
        ("parts", picked, PARTS),
        ("rows", tuple(ROWS) if rows is None else rows, tuple(ROWS)),
        ("presets", presets, tuple(PRESETS)),
        ("noise", noises, NOISES),
    ):
        wrong = [name for name in given if name not in known]
        if wrong or not given:
            raise _refusal(what, ", ".join(wrong) or "none", known)
    # A mesh twice as fine would take longer than all the rest of a quick study.
    nodes = {"max_nodes": QUICK_NODES, "corrected": False} if size == "quick" else {}
    made = {
        name: replace(PRESETS[name], meshing=replace(PRESETS[name].meshing, cache=cache, **nodes))
        for name in presets
    }
    cases = [
        Case(**case, preset_name=name, preset=preset, data=data, noisy=noise == "camera")
        for part in PARTS
        if part in picked
        for noise in noises
        for name, preset in made.items()
        for case in _asked(part, tuple(rows or ()), preset, size)
    ]
    if not cases:
        raise _refusal("parts", ", ".join(picked), PARTS)
    for name in dict.fromkeys(case.row.object for case in cases):
        _check_scene(data / name)
    return cases


def _refusal(what: str, value: str, known: Sequence[str]) -> InputError:
    return InputError(
        "a study has nothing to do with this", where=what, value=value,
        limit=", ".join(known), remedy=f"give {what}=[{known[0]}], for example",
    )  # fmt: skip


def _check_scene(folder: Path) -> None:
    if not (folder / "scene.json").is_file():
        raise InputError(
            "a scene of the study is missing", where="data", value=str(folder),
            limit="a folder for each object, with its scene.json",
            remedy="give data=FOLDER, the folder that holds the scenes, or fewer rows=[...]",
        )  # fmt: skip


def _asked(part: Part, rows: tuple[str, ...], preset: Preset, size: Size) -> Iterator[dict]:
    """What tells the cases of one part and preset apart."""
    full = size == "full"
    if part == "tables":
        for row in rows or (tuple(ROWS) if full else QUICK_ROWS):
            yield {"row": ROWS[row], "held_out": full}
        return
    if isinstance(preset.choice, Uniform):
        return
    if part == "processes":
        named = [ROWS[name] for name in rows or (tuple(ROWS) if full else QUICK_ROWS)]
        joint = {row.object: joint_row(row) for row in named}
        for row in joint.values():
            if row is not None:
                yield {"row": row, "held_out": full, "part": part}
    if part == "smoothness":
        for name, step in product(rows or (ABLATED if full else QUICK_ROWS[:1]), STEPS[size]):
            yield {"row": ROWS[name], "held_out": False, "part": part, "step": step}
    if part == "ensembles":
        named = rows or (tuple(REPEATED) if full else QUICK_ROWS[:1])
        for name, start, seed in product(named, STARTS[size], SEEDS[size]):
            repeat = {"start": start, "seed": seed}
            yield {"row": ROWS[name], "held_out": False, "part": part, **repeat}

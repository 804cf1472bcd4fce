"""Which fits a study of the paper makes, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from thermo.errors import InputError
from thermo.study import PRESETS, ROWS, paper_cases
from thermo.study import _paper_cases as module
from thermo.study._paper import REPEATED


def scenes(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).mkdir()
        (folder / name / "scene.json").write_text("{}")
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of all scenes, as far as the cases look into it."""
    return scenes(tmp_path_factory.mktemp("scenes"), *{row.object for row in ROWS.values()})


def asked(**more: Any) -> dict[str, Any]:
    """What a study is asked for when nobody says otherwise."""
    usual = {"parts": None, "rows": None, "presets": ["best"], "noises": ["none"], "size": "full"}
    return {**usual, **more}


def test_the_cases_of_the_tables(folder: Path) -> None:
    both: dict[str, Any] = {"presets": ["best", "paper"], "noises": ["none", "camera"]}
    full = paper_cases(folder, **asked(parts=["tables"], **both))
    assert len(full) == 12 * 2 * 2 and len({case.name() for case in full}) == 48
    assert len({case.key() for case in full}) == 48
    assert all(case.held_out and case.preset == PRESETS[case.preset_name] for case in full)
    quick = paper_cases(folder, **asked(size="quick", **both))
    assert len(quick) == 8 and not any(case.held_out for case in quick)
    assert {case.preset.meshing.max_nodes for case in quick} == {module.QUICK_NODES}
    assert not any(case.preset.meshing.corrected for case in quick)
    # Another folder of meshes is no other question.
    (moved,) = paper_cases(
        folder, **asked(parts=["tables"], rows=["cube-cooling"]), cache=folder / "elsewhere"
    )
    assert moved.key() in {case.key() for case in full}


def test_a_whole_study_has_every_part_and_no_fit_twice(folder: Path) -> None:
    cases = paper_cases(folder, **asked())
    of = {part: [case for case in cases if case.part == part] for part in module.PARTS}
    assert [len(found) for found in of.values()] == [12, 5, 12, 80]
    assert len({case.name() for case in cases}) == len({case.key() for case in cases}) == 109
    # The cylinder's cooling asks for another quantity than its heating.
    assert "cylinder" not in {case.row.object for case in of["processes"]}
    assert {case.row.runs() for case in of["processes"]} == {("cooling", "heating")}
    assert {case.row.name() for case in of["ensembles"]} == set(REPEATED)
    assert len({(case.start, case.seed) for case in of["ensembles"]}) == 16


def test_rows_may_be_named_for_each_part(folder: Path) -> None:
    rows = ["cube-heating", "cube-cooling"]
    cases = paper_cases(folder, **asked(rows=rows, size="quick", parts=list(module.PARTS)))
    counts = {part: sum(case.part == part for case in cases) for part in module.PARTS}
    assert counts == {"tables": 2, "processes": 1, "smoothness": 4, "ensembles": 8}


def test_what_cannot_vary_is_only_in_the_tables(folder: Path) -> None:
    cases = paper_cases(folder, **asked(presets=["uniform", "prior"]))
    assert {case.part for case in cases} == {"tables"}
    with pytest.raises(InputError) as caught:
        paper_cases(folder, **asked(presets=["uniform"], parts=["smoothness"]))
    assert caught.value.where == "parts"


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"rows": ["cube-warming"]}, "rows"),
        ({"presets": ["bestest"]}, "presets"),
        ({"presets": []}, "presets"),
        ({"rows": []}, "rows"),
        ({"parts": []}, "parts"),
        ({"noises": ["loud"]}, "noise"),
        ({"parts": ["figures"]}, "parts"),
        ({"rows": ["bear-cooling"]}, "data"),
    ],
)
def test_names_that_there_are_not_are_refused(
    change: dict[str, Any], where: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        paper_cases(scenes(tmp_path, "cube"), **asked(**{"rows": ["cube-cooling"], **change}))
    assert caught.value.where == where and caught.value.remedy

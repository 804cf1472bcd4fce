"""Repeated fits gathered from their folders."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import split_variance
from thermo.study import ensemble_record, gather, read_members

STARTS, SEEDS = (0.3, 1.0, 3.0), (0, 1, 2, 3)


def median_of(start: float, seed: int) -> float:
    return 0.2 * np.exp(0.02 * np.log(start) + 0.01 * np.sin(7.0 * seed + start))


def leave(folder: Path, start: float, seed: int, **more: Any) -> None:
    """A result as `thermo invert` leaves it, with what an ensemble reads."""
    middle = median_of(start, seed)
    quantiles = {"median": middle, "p05": 0.9 * middle, "p95": 1.2 * middle}
    record = {
        "verb": "invert",
        "fields": {"conductivity": {"unit": "W/m/K", **quantiles}},
        "fit": {"final_mae": {"lamp": 0.02, "cooling": 0.04}},
        "success": True,
        "configuration": {"data": "x", "runs": None, "init": start, "seed": seed, **more},
    }
    place = folder / f"init-{start},seed-{seed}"
    place.mkdir()
    (place / "result.json").write_text(json.dumps(record))


@pytest.fixture
def sweep(tmp_path: Path) -> Path:
    for start, seed in product(STARTS, SEEDS):
        leave(tmp_path, start, seed)
    return tmp_path


def test_a_balanced_sweep_is_split_by_start_and_seed(sweep: Path) -> None:
    members, units = read_members(sweep)
    found = gather(members, units)["conductivity"]
    table = np.log([[median_of(start, seed) for seed in SEEDS] for start in STARTS])
    assert found.members == 12 and found.unit == "W/m/K"
    assert found.median == pytest.approx(np.median(np.exp(table)))
    assert found.deviation == pytest.approx(table.std(ddof=1))
    assert found.width == pytest.approx(0.3) and found.final_error == pytest.approx(0.03)
    wanted = split_variance(table)
    assert found.split is not None
    assert found.split.within == pytest.approx(wanted.within)
    assert found.split.across == pytest.approx(wanted.across)
    record = ensemble_record(members, {"conductivity": found})
    field = record["fields"]["conductivity"]
    assert field["share_across"] == pytest.approx(wanted.share())
    assert len(record["members"]) == 12 and json.dumps(record)


def test_a_sweep_with_a_gap_is_not_split(sweep: Path) -> None:
    (sweep / "init-0.3,seed-2" / "result.json").unlink()
    (sweep / "other").mkdir()
    (sweep / "other" / "result.json").write_text('{"verb": "predict"}')
    members, units = read_members(sweep)
    found = gather(members, units)["conductivity"]
    assert found.members == 11 and found.split is None
    assert "share_across" not in ensemble_record(members, {"k": found})["fields"]["k"]


def test_one_start_alone_is_not_split(tmp_path: Path) -> None:
    for seed in SEEDS:
        leave(tmp_path, 1.0, seed)
    members, units = read_members(tmp_path)
    assert gather(members, units)["conductivity"].split is None


@pytest.mark.parametrize("kind", ["nothing", "one", "other data", "no folder"])
def test_what_is_no_ensemble_is_refused(kind: str, tmp_path: Path) -> None:
    place = tmp_path / "none" if kind == "no folder" else tmp_path
    if kind in ("one", "other data"):
        leave(tmp_path, 1.0, 0)
    if kind == "other data":
        leave(tmp_path, 1.0, 1, data="y")
    with pytest.raises(InputError, match="no repeated fits of one kind") as caught:
        read_members(place)
    assert caught.value.where == str(place)
    assert ("no such folder" in str(caught.value)) == (kind == "no folder")

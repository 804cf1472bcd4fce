"""Repeated fits gathered: how far they agree, and whether their starts or their seeds differ."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.identify import VarianceSplit, split_variance

REPEATED = ("init", "seed", "out")
"""Settings that may differ between repeated fits."""


@final
@dataclass(frozen=True)
class Member:
    """One of the repeated fits.

    - `name`: of its folder or row; `start`, `seed`: that it began with [1].
    - `median`: by field, over the surface [SI]; `width`: (p95 - p05) / median [1].
    - `final_error`: mean absolute residual at the last frame, over runs [K]; `success`.
    """

    name: str
    start: float
    seed: int
    median: dict[str, float]
    width: dict[str, float]
    final_error: float
    success: bool


@final
@dataclass(frozen=True)
class Ensemble:
    """Repeated fits of one field.

    - `members`: how many [1]; `unit`.
    - `median`: of their medians, in the unit; `deviation`: of the logarithms of these [1].
    - `width`: median of (p95 - p05) / median [1].
    - `split`: of the variance of the logarithms, None unless each start has the same seeds.
    - `final_error`: median residual at the last frame [K].
    """

    members: int
    unit: str
    median: float
    deviation: float
    width: float
    split: VarianceSplit | None
    final_error: float


def read_members(folder: Path) -> tuple[list[Member], dict[str, str]]:
    """The fits of a sweep, `thermo invert -m init=... seed=... out=FOLDER`, and the units [SI].

    Raises `InputError` where fewer than two fits are there, or they are not of one kind.
    """
    members, units, kinds = [], {}, set()
    for path in sorted(folder.glob("*/result.json")):
        record = json.loads(path.read_text("utf-8"))
        if record.get("verb") != "invert":
            continue
        fields, settings = record["fields"], record["configuration"]
        units |= {name: item["unit"] for name, item in fields.items()}
        kinds.add(json.dumps({k: v for k, v in settings.items() if k not in REPEATED}))
        median = {name: item["median"] for name, item in fields.items()}
        width = {n: (item["p95"] - item["p05"]) / median[n] for n, item in fields.items()}
        final = float(np.mean(list(record["fit"]["final_mae"].values())))
        begun = (float(settings["init"]), int(settings["seed"]))
        members.append(
            Member(path.parent.name, *begun, median, width, final, bool(record["success"]))
        )
    if len(members) < 2 or len(kinds) > 1:
        raise InputError(
            "these are no repeated fits of one kind",
            where=str(folder),
            value=f"{len(members)} fits, {len(kinds)} kinds of settings"
            if folder.is_dir()
            else "no such folder",
            limit=f"folders of at least two fits that differ in {', '.join(REPEATED)} only",
            remedy="run `thermo invert -m init=0.3,1,3 seed=0,1 data=... out=FOLDER` first",
        )
    return members, units


def gather(members: Sequence[Member], units: Mapping[str, str]) -> dict[str, Ensemble]:
    """How far repeated fits agree, by field [SI]."""
    return {name: _gathered(members, name, unit) for name, unit in units.items()}


def _gathered(members: Sequence[Member], name: str, unit: str) -> Ensemble:
    medians = np.array([member.median[name] for member in members])
    table = _balanced(members, np.log(medians))
    return Ensemble(
        members=len(members),
        unit=unit,
        median=float(np.median(medians)),
        deviation=float(np.log(medians).std(ddof=1)),
        width=float(np.median([member.width[name] for member in members])),
        split=None if table is None else split_variance(table),
        final_error=float(np.median([member.final_error for member in members])),
    )


def _balanced(
    members: Sequence[Member], values: Float[np.ndarray, " members"]
) -> Float[np.ndarray, "starts seeds"] | None:
    """The values by start and seed; None where one is missing or doubled, or there is but one."""
    starts = sorted({member.start for member in members})
    seeds = sorted({member.seed for member in members})
    table = np.full((len(starts), len(seeds)), np.nan)
    for member, value in zip(members, values, strict=True):
        table[starts.index(member.start), seeds.index(member.seed)] = value
    full = len(members) == table.size and np.isfinite(table).all() and min(table.shape) > 1
    return table if full else None


def ensemble_record(members: Sequence[Member], found: Mapping[str, Ensemble]) -> dict[str, Any]:
    """Every number of an ensemble as plain data [SI]."""
    fields = {}
    for name, item in found.items():
        fields[name] = {
            "unit": item.unit,
            "members": item.members,
            "median": item.median,
            "relative_deviation": item.deviation,
            "width": item.width,
            "final_mae": item.final_error,
        }
        if item.split is not None:
            fields[name] |= {
                "variance_within": item.split.within,
                "variance_across": item.split.across,
                "variance_across_raw": item.split.across_raw,
                "share_across": item.split.share(),
            }
    return {
        "format": "thermofield-result/1",
        "verb": "ensemble",
        "fields": fields,
        "members": [
            {"folder": m.name, "init": m.start, "seed": m.seed, "median": m.median,
             "final_mae": m.final_error, "success": m.success}
            for m in members
        ],
    }  # fmt: skip

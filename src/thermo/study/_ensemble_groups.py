"""Repeated fits of a study, gathered by scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from thermo.study._ensemble import Ensemble, Member, gather

Record = Mapping[str, Any]
"""What a case leaves [SI]."""


@final
@dataclass(frozen=True)
class Group:
    """Repeated fits of one row, preset and noise; `members` and `found` hold ratios [1]."""

    row: str
    preset: str
    noise: str
    members: list[Member]
    found: Ensemble


def groups(records: Sequence[Record]) -> list[Group]:
    """The repeated fits among the records, where a row has at least two of them."""
    apart: dict[tuple[str, str, str], list[Member]] = {}
    for one in records:
        if one["part"] == "ensembles":
            label = (one["row"], one["preset"], one["noise"])
            apart.setdefault(label, []).append(_member(one))
    return [
        Group(*label, members, gather(members, {"ratio": "1"})["ratio"])
        for label, members in apart.items()
        if len(members) > 1
    ]


def _member(one: Record) -> Member:
    median, width = {"ratio": one["ratio"]}, {"ratio": one["width_by_median"]}
    ends = (one["final_mae"], one["success"])
    return Member(one["row"], one["start"], one["seed"], median, width, *ends)

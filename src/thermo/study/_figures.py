"""The paper's figures 2 and 3 from the records of a study."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from thermo.report import RepeatedFits, TransferMap, figure_robustness, figure_transfer
from thermo.study._ensemble_groups import Group, Record, groups
from thermo.study._paper import HELD_OUT, REPEATED

SHOWN = ("bunny-cooling", "bear-cooling", "car-heating")
"""Scenes of the paper's figure 2."""


def write_figures(folder: Path, records: Sequence[Record]) -> list[Path]:
    """Draw what the records allow, for each preset and noise; returns the files."""
    made = []
    for preset, noise in dict.fromkeys((one["preset"], one["noise"]) for one in records):
        mine = [one for one in records if (one["preset"], one["noise"]) == (preset, noise)]
        repeated = [_repeated(group) for group in groups(mine)]
        if repeated:
            made.append(folder / f"robustness-{preset}-{noise}.png")
            figure_robustness(made[-1], repeated)
        fitted = {one["row"] for one in mine if one["part"] == "tables"}
        shown = [_map(folder, row, preset, noise) for row in SHOWN if row in fitted]
        maps = [one for one in shown if one is not None]
        if maps:
            made.append(folder / f"transfer-{preset}-{noise}.png")
            figure_transfer(made[-1], maps)
    return made


def _repeated(group: Group) -> RepeatedFits:
    split = group.found.split
    return RepeatedFits(
        label=group.row,
        starts=np.array([member.start for member in group.members]),
        ratios=np.array([member.median["ratio"] for member in group.members]),
        widths=np.array([member.width["ratio"] for member in group.members]),
        within=float("nan") if split is None else split.within**0.5,
        across=float("nan") if split is None else split.across**0.5,
        final_errors=np.array([member.final_error for member in group.members]),
        published=REPEATED.get(group.row),
    )


def _map(folder: Path, row: str, preset: str, noise: str) -> TransferMap | None:
    path = folder / f"{row}-{preset}-{noise}-maps.npz"
    if not path.exists():
        return None
    with np.load(path, allow_pickle=False) as stored:
        kept = dict(stored)
    test = next((name for name in reversed(HELD_OUT) if f"error_{name}" in kept), None)
    if test is None:
        return None
    return TransferMap(
        title=row,
        nodes=kept["nodes"],
        faces=kept["faces"],
        ratio=kept["ratio"],
        areas=kept["areas"],
        fitted=(kept["points"], kept["fitted"]),
        held_out=(kept[f"points_{test}"], kept[f"error_{test}"]),
    )

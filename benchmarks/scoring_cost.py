"""What scoring all candidates costs, over as many forward runs as there are columns.

    python benchmarks/scoring_cost.py SCENE [--repeats 3]

SCENE is a scene folder, such as a practice case. Programs are compiled before anything is timed,
and both are timed in turn in one process. A forward run is the stated model's, of all runs that are
fitted, on the linear cells and few steps that scores are taken on, and on those that `thermo
invert` uses; columns are the unknowns and every strength of every part of every candidate.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np

from thermo.discover._bench import set_up
from thermo.discover._discover import FRAMES, NODES, _begin
from thermo.discover._entries import entries
from thermo.discover._extended import readings
from thermo.discover._library import library, setting_of
from thermo.discover._pace import silent
from thermo.discover._scoring import scored
from thermo.inverse import Meshing, Prior, Stepping, Uniform, make_objective, unfitted


def seconds(work: Callable[[], object]) -> float:
    """How long a piece of work takes [s]."""
    begun = time.perf_counter()
    jax.block_until_ready(work())
    return time.perf_counter() - begun


def main() -> None:
    """Time both, and print the ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    task = unfitted(
        asked.scene, None, None, Uniform(), Prior(), Stepping(most_frames=FRAMES),
        Meshing(max_nodes=NODES), None, model_error=0.005,
    )  # fmt: skip
    bench = set_up(task)
    every = library(setting_of(task.scene, task.runs, bench.ready.mesh, task.names))
    begun, _, _ = _begin(bench, every, silent())
    laws = tuple(one for one in every if one.card.law)
    bare = replace(begun.point, candidates=())
    unknowns = begun.ended.slopes.shape[1]
    points = (begun.point, replace(begun.point, candidates=laws))
    columns = unknowns + sum(len(one.strengths) for point in points for one in entries(point))
    usual = make_objective(task, bench.ready, task.meshing.order)
    works = (
        lambda: scored(begun, laws, alpha=0.04).threshold,
        lambda: readings(bench.coarse, bare),
        lambda: readings(usual, bare),
    )
    times = np.array([[seconds(work) for work in works] for _ in range(asked.repeats + 1)])[1:]
    table, *runs = np.median(times, 0)
    print(f"{len(bench.ready.mesh.nodes)} nodes, {columns} columns, of which unknowns {unknowns}")
    print(f"the table {table:.2f} s")
    for what, one in zip(("scores are taken on", "a fit uses"), runs, strict=True):
        ratio = table / one / columns
        print(
            f"all runs forward on the cells that {what} {one:.3f} s, the table a column {ratio:.2f}"
        )


if __name__ == "__main__":
    main()

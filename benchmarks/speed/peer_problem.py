"""A problem and its reference as another interpreter reads them, and the record that it prints.

Needs NumPy and SciPy alone: the Python of a peer has no `thermo`.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from timing import peak_gb


@dataclass(frozen=True)
class Given:
    """A body of linear cells, its steps, and what the tight SciPy loop found.

    - `nodes` (nodes, 3) [m], `cells` (cells, 4), `faces` (faces, 3) of the boundary.
    - `conductivity` (cells,) [W/m/K], `capacity` [J/m3/K], `start` and `surroundings` [K],
      `convection` [W/m2/K], `radiating` [W/m2/K4]; `steps` of `size` [s].
    - `surface`: sorted numbers of the boundary's nodes; `run` and `target` (steps, surface) [K] at
      them; `slope` (cells,) [K2 per W/m/K].
    """

    name: str
    nodes: np.ndarray
    cells: np.ndarray
    faces: np.ndarray
    conductivity: np.ndarray
    capacity: float
    start: float
    surroundings: float
    convection: float
    radiating: float
    steps: int
    size: float
    surface: np.ndarray
    run: np.ndarray
    target: np.ndarray
    slope: np.ndarray


def read_given(path: Path) -> Given:
    """The problem and the reference that `measure.py` wrote."""
    with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
        arrays = dict(stored)
    surface = np.unique(arrays["faces"])
    column = KDTree(arrays.pop("places")).query(arrays["nodes"][surface])[1]
    arrays["run"], arrays["target"] = arrays["run"][:, column], arrays["target"][:, column]
    plain = {name: value.item() if value.ndim == 0 else value for name, value in arrays.items()}
    return Given(surface=surface, **plain)


def arguments(about: str, tasks: tuple[str, ...]) -> tuple[Given, str]:
    """The problem and the task that the command line names."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("task", choices=tasks)
    parser.add_argument("--reference", type=Path, required=True)
    given = parser.parse_args()
    return read_given(given.reference), given.task


def report(given: Given, who: str, task: str, found: np.ndarray, **measured: float) -> None:
    """Print the record of one measurement; `found` is `run` or `slope`."""
    if task == "forward":
        error = {"diff_K": float(np.abs(found - given.run)[-1].max())}
    else:
        off = np.linalg.norm(found - given.slope) / np.linalg.norm(given.slope)
        error = {"gradient_error": float(off)}
    record = {
        "problem": given.name,
        "who": who,
        "task": task,
        "nodes": len(given.nodes),
        "steps": given.steps,
        "peak_gb": peak_gb(),
        **measured,
        **error,
        "cpu_ms_per_step": 1e3 * measured["cpu_s"] / given.steps,
    }
    print(json.dumps(record))

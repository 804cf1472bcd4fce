"""The problems that every solver is timed on: a ball that cools in the dark.

M dT/dt + K(k) T + surface = load on straight TET4 or TET10, implicit Euler steps of 0.1 s,
convection, and radiation linearised at the old temperature. The gradient is that of the mean
squared difference of surface temperatures from a run with another conductivity, by the
conductivity of each cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermo.mesh import Mesh, ball_mesh, mesh_from_cells, promote
from thermo.observe import Heater
from thermo.physics.effects import STEFAN_BOLTZMANN

RADIUS = 0.03
SHELLS = {"s3k": 9, "s12k": 15, "s50k": 24, "s200k": 39, "s1m": 67}
MATERIALS = {"rock": (1030.0 * 1440.0, 0.1997), "alu": (2770.0 * 875.0, 148.6)}
START, SURROUNDINGS, CONVECTION, EMISSIVITY = 295.15, 258.15, 3.0, 0.92
SIZE = 0.1


@dataclass(frozen=True)
class Problem:
    """A body, its material and its steps.

    - `mesh`: [m]; `capacity` [J/m3/K]; `conductivity` [W/m/K] where a fit would begin, and
      `other`, that of the target, (cells,); `steps` of SIZE [s].
    - `start`, `surroundings`: [K]; `lamp`: one that shines at first, or None.
    """

    name: str
    mesh: Mesh
    capacity: float
    conductivity: np.ndarray
    other: np.ndarray
    steps: int
    start: float = START
    surroundings: float = SURROUNDINGS
    lamp: Heater | None = None


def make_problem(name: str, steps: int, meshes: str | None = None) -> Problem:
    """The problem of a name such as `s12k-rock` or `s12k-tet10-alu`.

    `meshes`: a folder with `s12k.npz` and so on, holding `points` [m] and `tets`, in place of the
    structured balls.
    """
    body, *order, material = name.split("-")
    if meshes is None:
        mesh = ball_mesh(RADIUS, SHELLS[body])
    else:
        with open(f"{meshes}/{body}.npz", "rb") as stream, np.load(stream) as stored:
            mesh = mesh_from_cells(stored["points"], stored["tets"])
    capacity, level = MATERIALS[material]
    x, y, z = mesh.nodes[mesh.cells[:, :4]].mean(1).T / RADIUS
    bump = 0.1 * np.sin(2.5 * x) * np.cos(2.0 * y) + 0.03 * z
    uniform = np.full(len(mesh.cells), level)
    other = uniform * (1 + np.clip(bump, -0.1, 0.1))
    return Problem(
        name, promote(mesh) if order == ["tet10"] else mesh, capacity, uniform, other, steps
    )


def as_arrays(problem: Problem) -> dict[str, np.ndarray]:
    """What `peer_problem.py` reads of a problem without a lamp; it says what each array is."""
    return {
        "name": np.array(problem.name),
        "nodes": problem.mesh.nodes,
        "cells": problem.mesh.cells,
        "faces": problem.mesh.faces,
        "conductivity": problem.conductivity,
        "capacity": np.array(problem.capacity),
        "start": np.array(problem.start),
        "surroundings": np.array(problem.surroundings),
        "convection": np.array(CONVECTION),
        "radiating": np.array(EMISSIVITY * STEFAN_BOLTZMANN),
        "steps": np.array(problem.steps),
        "size": np.array(SIZE),
    }

"""What is left open of two fields on a ball, from covariances that are chosen."""

from __future__ import annotations

import numpy as np

from thermo.fields import QUANTITIES, departing_field, place_control_points
from thermo.inverse import FieldPosterior, Smoothness
from thermo.inverse._properties import Stated
from thermo.mesh import ball_mesh

MESH = ball_mesh(0.05, 2)
COUNT = 8
NAMES = ("conductivity", "convection")
SIZE = len(NAMES) * COUNT


def smoothness(
    sd: float, *, weight: float = 1.0, move: float = 0.0, prior: float = 1.0
) -> Smoothness:
    """Independent controls with one standard deviation after the data and one before [1]."""
    return Smoothness(
        dict.fromkeys(NAMES, 0.3), weight, np.full(SIZE, move), sd**2 * np.eye(SIZE),
        prior**2 * np.eye(SIZE),
    )  # fmt: skip


def left(*mixture: Smoothness, shift: float = 0.0) -> FieldPosterior:
    """Fields of 2 in their units; `shift` of one run at all controls [1]."""
    fields, points = {}, {}
    for seed, name in enumerate(NAMES):
        controls = place_control_points(MESH, COUNT, seed=seed)
        cells, faces = np.full(len(MESH.cells), 2.0), np.full(len(MESH.faces), 2.0)
        fields[name] = departing_field(QUANTITIES[name], MESH, controls, cells, faces)
        points[name] = controls.points
    stated = Stated(2.0, 1e6, 2.0, 0.5)
    return FieldPosterior(MESH, 1, stated, fields, points, list(mixture), np.full((SIZE, 1), shift))

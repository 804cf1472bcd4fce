"""A field that departs from a given one: nothing at zero, a factor, smooth in between."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from thermo.fields import QUANTITIES, DepartingField, departing_field, place_control_points
from thermo.mesh import ball_mesh

MESH = ball_mesh(0.05, 2)
CONTROLS = place_control_points(MESH, 9)
CELLS = np.linspace(0.5, 2.0, len(MESH.cells))
FACES = np.linspace(1.0, 3.0, len(MESH.faces))


def field() -> DepartingField:
    return departing_field(QUANTITIES["conductivity"], MESH, CONTROLS, CELLS, FACES)


def test_it_begins_as_what_it_departs_from_however_that_varies() -> None:
    assert np.array_equal(field().cell_values(), CELLS)
    assert np.array_equal(field().face_values(), FACES)
    centres = MESH.nodes[MESH.faces[:, :3]].mean(1)
    away = np.linalg.norm(CONTROLS.points[:, None] - centres, axis=-1)
    # A control is a corner of several faces, which may be as near as each other.
    for value, distance in zip(field().control_values(), away, strict=True):
        assert value in FACES[distance < distance.min() + 1e-9]


def test_one_departure_everywhere_is_a_factor() -> None:
    moved = field().with_parameters(jnp.full(9, 0.7))
    assert np.allclose(moved.cell_values(), CELLS * np.exp(0.7))
    assert np.allclose(moved.face_values(), FACES * np.exp(0.7))
    assert np.allclose(moved.smooth_values(), np.log(moved.control_values()))


def test_logarithms_depart_by_what_lies_between_the_controls() -> None:
    random = np.random.default_rng(0)
    one, other = random.standard_normal((2, 9))
    logs = [
        np.log(np.asarray(field().with_parameters(jnp.asarray(d)).face_values()) / FACES)
        for d in (one, other, one + other)
    ]
    assert np.allclose(logs[0] + logs[1], logs[2])
    assert np.abs(logs[0]).max() <= np.abs(one).max()

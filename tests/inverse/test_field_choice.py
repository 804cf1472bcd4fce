"""The choices of field: how many parameters they have, where they start, what seeds do."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from thermo.fields import QUANTITIES
from thermo.inverse import AbstractFieldChoice, Network, OnControlPoints, Patchwise, Uniform
from thermo.mesh import box_mesh

MESH = box_mesh((0.02, 0.012, 0.008), (6, 4, 3))
QUANTITY = QUANTITIES["conductivity"]
DIRECT = [(Uniform(), 1), (Patchwise(patches=5), 5), (OnControlPoints(count=9), 9)]
SEEDED: list[AbstractFieldChoice] = [
    Patchwise(patches=5), OnControlPoints(count=9), Network(count=9, width=8)
]  # fmt: skip


def leaves(choice: AbstractFieldChoice, seed: int = 0, initial: float = 2.0) -> list[np.ndarray]:
    field, _ = choice.make(QUANTITY, MESH, initial, seed)
    return [np.asarray(leaf) for leaf in jax.tree.leaves(field.parameters())]


@pytest.mark.parametrize(("choice", "count"), DIRECT)
def test_direct_fields_have_a_parameter_for_each_control_and_start_uniform(
    choice: AbstractFieldChoice, count: int
) -> None:
    field, pairs = choice.make(QUANTITY, MESH, 2.0, 0)
    assert sum(leaf.size for leaf in leaves(choice)) == count
    cells, faces = np.asarray(field.cell_values()), np.asarray(field.face_values())
    assert cells.shape == (len(MESH.cells),) and faces.shape == (len(MESH.faces),)
    assert np.allclose(cells, 2.0, rtol=1e-9) and np.allclose(faces, 2.0, rtol=1e-9)
    assert (len(pairs) == 0) == (count == 1)
    assert len(pairs) == 0 or (pairs.min() >= 0 and pairs.max() == count - 1)


@pytest.mark.parametrize("octaves", [0, 2])
def test_the_network_has_the_parameters_of_its_layers(octaves: int) -> None:
    choice = Network(count=9, octaves=octaves, width=8, depth=2)
    features = 4 + 6 * octaves
    wanted = (features + 1) * 8 + (8 + 1) * 8 + (8 + 1)
    assert sum(leaf.size for leaf in leaves(choice)) == wanted


@pytest.mark.parametrize("linear", [False, True])
def test_the_network_starts_near_the_initial_value(linear: bool) -> None:
    quantity = QUANTITIES["emissivity"]
    field, _ = Network(count=9, width=8, linear=linear).make(quantity, MESH, 0.5, 3)
    values = np.asarray(field.cell_values())
    assert np.abs(np.log(values / 0.5)).max() < 0.5
    assert np.ptp(values) > 0


@pytest.mark.parametrize("choice", SEEDED)
def test_the_seed_alone_decides(choice: AbstractFieldChoice) -> None:
    def places(seed: int) -> list[np.ndarray]:
        field, pairs = choice.make(QUANTITY, MESH, 2.0, seed)
        arrays = [leaf for leaf in jax.tree.leaves(field) if np.size(leaf) > 1]
        return [pairs, *map(np.asarray, arrays)]

    first, again, other = places(1), places(1), places(2)
    assert all(map(np.array_equal, first, again))
    assert not all(map(np.array_equal, first, other))


def test_a_patch_has_one_value_and_points_are_interpolated() -> None:
    values = {}
    for choice in (Patchwise(patches=5), OnControlPoints(count=5)):
        field, _ = choice.make(QUANTITY, MESH, 2.0, 0)
        moved = field.with_parameters(field.parameters() + 0.3 * np.arange(5))
        values[type(choice)] = len(np.unique(np.round(np.asarray(moved.cell_values()), 9)))
    assert values[Patchwise] == 5
    assert values[OnControlPoints] > 5


@pytest.mark.parametrize(("choice", "count"), DIRECT)
def test_parameters_are_not_weakly_typed(choice: AbstractFieldChoice, count: int) -> None:
    """Otherwise the second step of every fit would be compiled anew."""
    field, _ = choice.make(QUANTITY, MESH, 2.0, 0)
    assert all(not leaf.weak_type for leaf in jax.tree.leaves(field.parameters())), count

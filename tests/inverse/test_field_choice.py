"""The choices of field: how many parameters they have, where they start, what seeds do."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.fields import (
    QUANTITIES,
    AbstractField,
    DirectField,
    TwoMaterialField,
    place_control_points,
)
from thermo.inverse import (
    AbstractFieldChoice,
    AbstractStagedChoice,
    Network,
    OnControlPoints,
    Patchwise,
    TwoMaterials,
    Uniform,
)
from thermo.mesh import Mesh, box_mesh, promote

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


@pytest.mark.parametrize("choice", [Uniform(), Patchwise(), OnControlPoints(), Network()])
def test_only_two_materials_change_their_field_between_stages(choice: AbstractFieldChoice) -> None:
    assert not isinstance(choice, AbstractStagedChoice)
    assert isinstance(TwoMaterials(), AbstractStagedChoice)


def in_halves(choice: TwoMaterials, seed: int) -> tuple[AbstractField, np.ndarray]:
    """A field of the first stage, 1 left and 4 right of the middle."""
    field, pairs = choice.make(QUANTITY, MESH, 2.0, seed)
    points = place_control_points(MESH, choice.count, seed=seed).points
    values = jnp.asarray(np.where(points[:, 0] < 0.01, 1.0, 4.0))
    assert isinstance(field, DirectField)
    return field.with_parameters(field.head.raw(values)), pairs


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize("mesh", [MESH, promote(MESH)])
def test_two_materials_part_the_field_of_their_first_stage(mesh: Mesh, seed: int) -> None:
    choice = TwoMaterials(count=40)
    field, pairs = choice.go_on(*in_halves(choice, seed), mesh, seed)
    assert isinstance(field, TwoMaterialField) and field.quantity == QUANTITY
    assert np.allclose(field.head.value(field.levels), [1.0, 4.0], rtol=1e-9)
    assert pairs.min() >= 0 and pairs.max() < len(field.shifts) <= 40
    centres = mesh.nodes[mesh.cells[:, :4]].mean(1)[:, 0]
    for side, level in ((centres < 0.003, 1.0), (centres > 0.017, 4.0)):
        assert np.allclose(np.asarray(field.cell_values())[side], level, rtol=1e-2)


def test_two_materials_begin_on_control_points() -> None:
    ours, theirs = (
        choice.make(QUANTITY, MESH, 2.0, 1) for choice in (TwoMaterials(9), OnControlPoints(9))
    )
    assert np.array_equal(ours[1], theirs[1])
    assert all(map(np.array_equal, jax.tree.leaves(ours[0]), jax.tree.leaves(theirs[0])))


def test_two_materials_leave_a_uniform_field_as_it_is() -> None:
    choice = TwoMaterials(count=9)
    field, pairs = choice.make(QUANTITY, MESH, 2.0, 0)
    again, same = choice.go_on(field, pairs, MESH, 0)
    assert again is field and same is pairs

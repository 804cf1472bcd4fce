"""Two materials: who belongs to which, where the boundary begins, how it moves, derivatives."""

from __future__ import annotations

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.fields import (
    QUANTITIES,
    ControlPoints,
    LogHead,
    TwoMaterialField,
    place_control_points,
    two_material_field,
    two_material_values,
)
from thermo.fields._two_materials import (
    CELL_POINTS,
    FACE_POINTS,
    SHIFT,
    _calmed,
    _heights,
    _weights,
    two_groups,
)
from thermo.mesh import Mesh, box_mesh, cell_volumes, face_areas, mesh_from_cells

CONDUCTIVITY = QUANTITIES["conductivity"]
HEAD = LogHead(CONDUCTIVITY.lower, CONDUCTIVITY.upper)
SIZE = (0.04, 0.02, 0.02)
LAYERS = 12
# Midway between two layers of nodes, so that no control stands on the plane.
PLANE = SIZE[0] * 5.5 / LAYERS
SEEDS = (0, 1, 2)
SHARES = 0.5 ** np.arange(2, 7)
SCORES = st.lists(st.integers(-40, 40).map(lambda n: n / 8), min_size=2, max_size=12)


@cache
def box() -> Mesh:
    return box_mesh(SIZE, (LAYERS, 6, 6))


@cache
def controls(seed: int = 1) -> ControlPoints:
    return place_control_points(box(), 60, seed=seed)


def sides(seed: int = 1) -> np.ndarray:
    return np.where(controls(seed).points[:, 0] < PLANE, 1.0, 4.0)


def spacing(seed: int = 1) -> float:
    ends = controls(seed).points[controls(seed).pairs]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))


def parted(
    mesh: Mesh, points: ControlPoints, values: np.ndarray
) -> tuple[TwoMaterialField, np.ndarray]:
    found = two_material_field(CONDUCTIVITY, mesh, HEAD, points, values)
    assert found is not None
    return found


@cache
def halves(seed: int = 1) -> tuple[TwoMaterialField, np.ndarray]:
    return parted(box(), controls(seed), sides(seed))


def levels(field: TwoMaterialField) -> np.ndarray:
    return np.asarray(field.head.value(field.levels))


def shifted(field: TwoMaterialField, shifts: np.ndarray | float) -> TwoMaterialField:
    moved = jnp.broadcast_to(jnp.asarray(shifts, float), field.shifts.shape)
    return field.with_parameters({"levels": field.levels, "shifts": moved})


def cell_centres() -> np.ndarray:
    return box().nodes[box().cells[:, :4]].mean(1)


def place(field: TwoMaterialField) -> float:
    """Where a plane boundary stands that parts the box into the same shares of log values [m]."""
    low, high = np.log(levels(field))
    share = (np.log(np.asarray(field.cell_values())) - low) / (high - low)
    return SIZE[0] * (1 - np.average(share, weights=cell_volumes(box())))


def spread_of_cut(order: np.ndarray, cut: int) -> float:
    return sum(((part - part.mean()) ** 2).sum() for part in (order[:cut], order[cut:]))


@given(values=SCORES)
def test_two_groups_are_the_best_of_all_cuts(values: list[float]) -> None:
    numbers = np.asarray(values)
    order = np.sort(numbers)
    best = min(spread_of_cut(order, cut) for cut in range(1, len(order)))
    upper, low, high = two_groups(numbers)
    found = ((numbers - np.where(upper, high, low)) ** 2).sum()
    np.testing.assert_allclose(found, best, rtol=1e-10, atol=1e-10)
    if upper.any():
        assert numbers[~upper].max() < numbers[upper].min()
        means = numbers[~upper].mean(), numbers[upper].mean()
        np.testing.assert_allclose((low, high), means, rtol=1e-12, atol=1e-12)


@given(value=st.floats(-20, 20), count=st.integers(2, 30))
def test_equal_values_are_all_in_the_lower_group(value: float, count: int) -> None:
    upper, low, high = two_groups(np.full(count, value))
    assert not upper.any()
    np.testing.assert_allclose((low, high), value, rtol=1e-12, atol=1e-12)


@given(values=SCORES, seed=st.integers(0, 1000))
def test_two_groups_do_not_depend_on_the_order(values: list[float], seed: int) -> None:
    numbers = np.asarray(values)
    order = np.random.default_rng(seed).permutation(len(numbers))
    upper, low, high = two_groups(numbers)
    again, *means = two_groups(numbers[order])
    np.testing.assert_array_equal(again, upper[order])
    assert means == [low, high]


def test_calming_draws_a_lone_control_to_its_neighbours() -> None:
    star = np.array([[0, 1], [0, 2], [0, 3]])
    got = _calmed(np.array([1.0, 0.0, 0.0, 0.6]), star)
    np.testing.assert_allclose(got, [1.4 / 3, 2 / 3, 2 / 3, 2.6 / 3], rtol=1e-14)


def test_calming_leaves_a_control_without_neighbours() -> None:
    got = _calmed(np.array([1.0, 3.0, 7.0]), np.array([[0, 1]]))
    np.testing.assert_allclose(got, [7 / 3, 5 / 3, 7.0], rtol=1e-14)


@given(value=st.floats(-5, 5), seed=st.integers(0, 1000))
def test_calming_keeps_constants_and_stays_within_the_values(value: float, seed: int) -> None:
    pairs, make = controls().pairs, np.random.default_rng(seed)
    flat = np.full(len(controls().points), value)
    np.testing.assert_allclose(_calmed(flat, pairs), value, rtol=1e-13, atol=1e-13)
    rough = make.normal(size=len(flat))
    assert np.ptp(_calmed(rough, pairs)) < np.ptp(rough)


def by_hand(points: np.ndarray, pairs: list[tuple[int, int]]) -> ControlPoints:
    neighbours = np.asarray(pairs, dtype=int).reshape(-1, 2)
    return ControlPoints(points, np.arange(len(points)), np.zeros((len(points), 1)), neighbours)


@pytest.mark.parametrize("log", [(0.0, 2.0), (2.0, 0.0)])
def test_heights_are_signed_distances_to_where_the_middle_is_passed(
    log: tuple[float, float],
) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    line = by_hand(points, [(0, 1)])
    values = np.asarray(log)
    got = _heights(line, values, values > 0.5, 0.5)
    expected = [-0.25, 0.75] if log[0] < log[1] else [0.75, -0.25]
    np.testing.assert_allclose(got, expected, rtol=1e-14)


def moments(corners: int) -> np.ndarray:
    """Mean of the products of two barycentric coordinates over a simplex."""
    return (1 + np.eye(corners)) / (corners * (corners + 1))


@pytest.mark.parametrize("points", [CELL_POINTS, FACE_POINTS])
def test_the_points_of_a_cell_are_exact_to_the_second_degree(points: np.ndarray) -> None:
    np.testing.assert_allclose(points.sum(1), 1.0, rtol=1e-14)
    assert (points > 0).all()
    found = points.T @ points / len(points)
    np.testing.assert_allclose(found, moments(len(points)), rtol=1e-12)


def test_weights_meet_the_controls_and_keep_a_plane() -> None:
    corners, one = box().nodes[box().cells[:40, :4]], np.ones((1, 1))
    at_controls = _weights(controls().points, controls().points[:, None], one)[:, 0]
    np.testing.assert_allclose(at_controls, np.eye(60), atol=1e-10)
    weights = _weights(controls().points, corners, CELL_POINTS)
    np.testing.assert_allclose(weights.sum(-1), 1.0, rtol=1e-10)
    expected = np.einsum("qc,pcx->pqx", CELL_POINTS, corners)
    np.testing.assert_allclose(weights @ controls().points, expected, atol=1e-12)


def test_weights_of_controls_in_one_plane_keep_constants() -> None:
    flat = controls().points[controls().points[:, 2] == 0.0]
    assert len(flat) > 8
    corners = box().nodes[box().cells[:40, :4]]
    weights = _weights(flat, corners, CELL_POINTS)
    np.testing.assert_allclose(weights.sum(-1), 1.0, rtol=1e-10)


def rings(step: float) -> ControlPoints:
    """Two rings of controls around a bar, one on each side of the plane at two steps [m]."""
    around = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0)]
    points = step * np.array([(x, y, z) for x in (1.5, 2.5) for y, z in around])
    along = [(k, (k + 1) % 8) for k in range(8)]
    across = [(k, k + 8) for k in range(8)]
    return by_hand(points, [*along, *((a + 8, b + 8) for a, b in along), *across])


def blend(height: np.ndarray, low: float, high: float) -> np.ndarray:
    return low * (high / low) ** ((1 + np.tanh(height)).mean(1) / 2)


@pytest.mark.parametrize("shift", [-0.7, 0.0, 0.4])
def test_a_plane_boundary_has_a_closed_form(shift: float) -> None:
    step = 0.01
    bar = box_mesh((4 * step, 2 * step, 2 * step), (8, 4, 4))
    values = np.repeat([1.0, 4.0], 8)
    field = shifted(parted(bar, rings(step), values)[0], shift)
    # Half an edge, and edges are half a step.
    width = step / 4
    for found, corners, rule in (
        (field.cell_values(), bar.nodes[bar.cells], CELL_POINTS),
        (field.face_values(), bar.nodes[bar.faces], FACE_POINTS),
    ):
        away = corners[..., 0] @ rule.T - 2 * step
        expected = blend((away + SHIFT * step * shift) / width, 1.0, 4.0)
        np.testing.assert_allclose(found, expected, rtol=1e-8)
    near = np.repeat([-0.5, 0.5], 8) * step + SHIFT * step * shift
    expected = blend(near[:, None] / width, 1.0, 4.0)
    np.testing.assert_allclose(field.control_values(), expected, rtol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_far_from_the_plane_a_cell_has_its_level(seed: int) -> None:
    away = cell_centres()[:, 0] - PLANE
    found = np.asarray(halves(seed)[0].cell_values())
    for side, level in ((-away, 1.0), (away, 4.0)):
        far = side > 1.25 * spacing(seed)
        assert far.sum() > 100
        np.testing.assert_allclose(found[far], level, rtol=1e-3)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_boundary_begins_near_the_plane(seed: int) -> None:
    field, _ = halves(seed)
    centres = cell_centres()[:, 0]
    strayed = (np.asarray(field.cell_values()) > 2.0) != (centres > PLANE)
    assert np.abs(centres - PLANE)[strayed].max(initial=0.0) < 0.4 * spacing(seed)
    assert abs(place(field) - PLANE) < 0.2 * spacing(seed)


@given(seed=st.integers(0, 1000))
def test_levels_are_the_geometric_means_of_the_groups(seed: int) -> None:
    points = rings(0.01)
    bar = box_mesh((0.04, 0.02, 0.02), (4, 2, 2))
    values = np.repeat([1.0, 4.0], 8) * np.exp(0.1 * np.random.default_rng(seed).normal(size=16))
    field, _ = parted(bar, points, values)
    expected = np.exp([np.log(values[:8]).mean(), np.log(values[8:]).mean()])
    np.testing.assert_allclose(levels(field), expected, rtol=1e-9)


def test_controls_near_the_boundary_shift_it_and_are_paired() -> None:
    field, pairs = halves()
    count = len(field.shifts)
    assert 10 < count < 60
    assert not np.asarray(field.smooth_values()).any()
    assert field.control_values().shape == field.smooth_values().shape == (count,)
    assert set(pairs.ravel()) == set(range(count))
    near = np.abs(controls().points[:, 0] - PLANE) < 0.5 * spacing()
    assert count > near.sum()


@pytest.mark.parametrize("value", [0.3, 7.0])
def test_a_uniform_field_is_not_parted(value: float) -> None:
    values = np.full(60, value)
    assert two_material_field(CONDUCTIVITY, box(), HEAD, controls(), values) is None
    assert two_material_field(CONDUCTIVITY, box(), HEAD, controls(), sides()) is not None


def strays(left: bool) -> np.ndarray:
    """Some controls [1] far from the plane, on one side of it."""
    away = (PLANE - controls().points[:, 0]) * (1 if left else -1)
    return np.flatnonzero(away > 1.4 * spacing())[:4]


def has_island(left: bool, value: float) -> bool:
    """Whether a stray control of this value anywhere on that side leaves a piece of its own."""
    away = (PLANE - cell_centres()[:, 0]) * (1 if left else -1)
    found = []
    for stray in strays(left):
        values = np.where(np.arange(60) == stray, value, sides())
        field, _ = parted(box(), controls(), values)
        upper = np.asarray(field.cell_values()) > np.sqrt(np.prod(levels(field)))
        found.append((upper[away > 0.75 * spacing()] == left).any())
    assert len(found) == 4
    return any(found)


def test_a_stray_control_between_the_levels_makes_no_island() -> None:
    assert not has_island(True, 3.0)
    assert not has_island(False, 1.5)


@pytest.mark.parametrize("beyond", [1.0, 1.5])
def test_a_stray_control_at_the_other_level_or_beyond_makes_no_island(beyond: float) -> None:
    assert not (has_island(True, 4.0 * beyond) or has_island(False, 1.0 / beyond))


def test_equal_controls_on_both_sides_of_the_boundary() -> None:
    along = controls(2).points[:, 0] / SIZE[0]
    values = np.where(along < 0.4, 1.0, np.where(along < 0.6, 2.1, 4.0))
    field, _ = parted(box(), controls(2), values)
    assert np.isfinite(np.asarray(field.cell_values())).all()


@pytest.mark.parametrize("count", [LAYERS, 17, 2 * LAYERS])
def test_a_boundary_apart_from_its_mesh_is_sharp_on_any(count: int) -> None:
    field = shifted(halves()[0], 0.4)
    mesh = box_mesh(SIZE, (count, 6, 6))
    low, high = np.log(levels(field))
    cells, faces = two_material_values(field.boundary(), mesh)
    for values, sizes in ((cells, cell_volumes(mesh)), (faces, face_areas(mesh))):
        share = (np.log(values) - low) / (high - low)
        assert share.min() >= -1e-9 and share.max() <= 1 + 1e-9
        cut = (share > 1e-3) & (share < 1 - 1e-3)
        # The boundary bends by less than a layer, so that it cuts no more than three.
        assert 0 < sizes[cut].sum() < 3 * sizes.sum() / count
    share = (np.log(cells) - low) / (high - low)
    middle = SIZE[0] * (1 - np.average(share, weights=cell_volumes(mesh)))
    assert middle == pytest.approx(place(field), abs=0.01 * SIZE[0])


def hollow() -> Mesh:
    whole = box_mesh((0.02, 0.02, 0.02), (5, 5, 5))
    centres = whole.nodes[whole.cells].mean(1)
    keep = (np.abs(centres - 0.01) > 0.002).any(1)
    return mesh_from_cells(whole.nodes, whole.cells[keep], where="hollow")


def test_materials_whose_surfaces_do_not_touch() -> None:
    mesh = hollow()
    points = place_control_points(mesh, 40)
    inside = (np.abs(points.points - 0.01) < 0.003).all(1)
    assert inside.any()
    found = two_material_field(CONDUCTIVITY, mesh, HEAD, points, np.where(inside, 4.0, 1.0))
    assert found is None or np.isfinite(np.asarray(found[0].cell_values())).all()


def test_a_single_control_is_not_parted() -> None:
    points = place_control_points(box(), 1)
    assert two_material_field(CONDUCTIVITY, box(), HEAD, points, np.ones(1)) is None


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("shift", [-0.5, -0.25, 0.25, 0.5])
def test_shifts_move_the_boundary_into_the_lower_side(seed: int, shift: float) -> None:
    field, _ = halves(seed)
    moved = place(field) - place(shifted(field, shift))
    assert 0.9 < moved / (SHIFT * spacing(seed) * shift) < 1.3


def test_one_shift_moves_the_boundary_near_its_control_only() -> None:
    field, _ = halves()
    ends = np.asarray(field.cell_values()), np.asarray(shifted(field, 0.5).cell_values())
    one = np.eye(len(field.shifts))[0] * 0.5
    moved = np.asarray(shifted(field, one).cell_values())
    share = np.log(moved / ends[0]).sum() / np.log(ends[1] / ends[0]).sum()
    assert 0.3 / len(one) < share < 3 / len(one)


@given(
    size=st.floats(0.01, 30), seed=st.integers(0, 1000),
    raw=st.tuples(st.floats(-4, 4), st.floats(-4, 4)),
)  # fmt: skip
def test_values_lie_between_the_levels(size: float, seed: int, raw: tuple[float, float]) -> None:
    field, _ = halves()
    shifts = size * np.random.default_rng(seed).normal(size=field.shifts.shape)
    moved = field.with_parameters({"levels": jnp.asarray(raw), "shifts": jnp.asarray(shifts)})
    low, high = np.sort(levels(moved))
    for values in (moved.cell_values(), moved.face_values(), moved.control_values()):
        found = np.asarray(values)
        assert low * (1 - 1e-12) <= found.min() <= found.max() <= high * (1 + 1e-12)


def test_parameters_round_trip() -> None:
    field, _ = halves()
    moved = jax.tree.map(lambda leaf: leaf + 0.3, field.parameters())
    again = field.with_parameters(moved)
    assert set(moved) == {"levels", "shifts"}
    jax.tree.map(np.testing.assert_array_equal, again.parameters(), moved)
    assert not np.array_equal(again.cell_values(), field.cell_values())
    back = again.with_parameters(field.parameters())
    np.testing.assert_array_equal(back.cell_values(), field.cell_values())
    np.testing.assert_array_equal(back.face_values(), field.face_values())
    assert all(not leaf.weak_type for leaf in jax.tree.leaves(field.parameters()))


@pytest.mark.parametrize("name", ["cell_values", "face_values"])
def test_taylor_remainder(name: str) -> None:
    field, _ = halves()
    weight = jnp.asarray(np.random.default_rng(2).normal(size=len(getattr(field, name)())))

    @jax.jit
    def value(parameters: dict[str, jax.Array]) -> jax.Array:
        return jnp.vdot(weight, getattr(field.with_parameters(parameters), name)())

    make = np.random.default_rng(3)
    start = jax.tree.map(
        lambda leaf: leaf + jnp.asarray(0.3 * make.normal(size=leaf.shape)), field.parameters()
    )
    way = jax.tree.map(lambda leaf: jnp.asarray(make.normal(size=leaf.shape)), start)
    _, forward = jax.jvp(value, (start,), (way,))
    slope = jax.grad(value)(start)
    assert all(np.asarray(leaf).all() for leaf in jax.tree.leaves(slope))
    reverse = sum(float(jnp.vdot(slope[key], way[key])) for key in way)
    np.testing.assert_allclose(forward, reverse, rtol=1e-10)

    def rest(share: float) -> float:
        there = jax.tree.map(lambda leaf, along: leaf + share * along, start, way)
        return abs(float(value(there) - value(start)) - share * reverse)

    remainder = [rest(share) for share in 0.02 * SHARES]
    assert np.polyfit(np.log(SHARES), np.log(remainder), 1)[0] > 1.9

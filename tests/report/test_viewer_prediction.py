"""The viewer of a prediction: temperatures of the boundary, residuals of what is near, fields."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import Prediction, RecoveredField
from thermo.mesh import Mesh, box_mesh, promote
from thermo.report._viewer import Viewer
from thermo.report._viewer_prediction import boundary_triangles, spread, viewer_of_prediction

# A plate of 40 x 40 x 4 mm.
PLATE = box_mesh((0.04, 0.04, 0.004), (8, 8, 2))
TIME = np.arange(7.0) * 2.0
GRID = np.stack(np.meshgrid(*[np.linspace(0.002, 0.038, 10)] * 2), axis=-1).reshape(-1, 2)
TOP = np.column_stack([GRID, np.full(len(GRID), 0.004)])


def body(points: np.ndarray, time: np.ndarray) -> np.ndarray:
    return 300.0 + time[:, None] + 100.0 * points[:, 0] + 50.0 * points[:, 2]


def prediction(mesh: Mesh = PLATE, points: np.ndarray = TOP) -> Prediction:
    """Simulated temperatures are linear; readings are lower by 0.01 K for each second."""
    moments = TIME[[0, 3, 6]]
    simulated = body(points, TIME)
    measured = simulated - 0.01 * TIME[:, None]
    return Prediction(
        points, TIME, simulated, measured, {}, mesh, moments, body(mesh.nodes, moments)
    )


def layer(viewer: Viewer, name: str) -> np.ndarray:
    (found,) = [one.values for one in viewer.layers if one.name == name]
    return found


@pytest.mark.parametrize("mesh", [PLATE, promote(PLATE)])
def test_the_boundary_has_its_temperature_and_turn(mesh: Mesh) -> None:
    made = viewer_of_prediction("plate", prediction(mesh))
    assert len(made.triangles) == len(PLATE.faces) * (1 if mesh is PLATE else 4)
    assert len(made.vertices) == len(mesh.surface_nodes)
    np.testing.assert_allclose(
        layer(made, "temperature"), body(made.vertices, TIME[[0, 3, 6]]), atol=1e-9
    )
    # The divergence theorem gives the volume only where all triangles turn outward.
    a, b, c = (made.vertices[made.triangles[:, i]] for i in range(3))
    assert np.einsum("ij,ij->", np.cross(a, b), c) / 6 == pytest.approx(0.04 * 0.04 * 0.004)
    assert [one.name for one in made.layers] == ["temperature", "residual"]
    np.testing.assert_array_equal(made.layers[0].time, TIME[[0, 3, 6]])


def test_the_residual_is_of_the_moment_and_of_the_side_that_was_read() -> None:
    made = viewer_of_prediction("plate", prediction())
    residual, height = layer(made, "residual"), made.vertices[:, 2]
    known = np.isfinite(residual)
    # The same samples at every moment, with the value of that moment everywhere.
    assert (known == known[0]).all()
    for row, time in zip(residual, TIME[[0, 3, 6]], strict=True):
        np.testing.assert_allclose(row[known[0]], 0.01 * time, atol=1e-12)
    assert known[0][height == 0.004].all()
    # The plate is thinner than the samples lie apart, and yet its underside was not read.
    middle = (np.abs(made.vertices[:, :2] - 0.02) < 0.018).all(axis=1)
    assert middle.any() and not known[0][(height == 0.0) & middle].any()
    assert made.readings is not None
    np.testing.assert_allclose(made.readings.values, prediction().measured[[0, 3, 6]])


def test_samples_are_weighted_by_their_distance() -> None:
    points = TOP[[0, 1]]
    between = points[0] + np.outer([0.0, 0.5, 0.25, 1.0], points[1] - points[0])
    surface = np.vstack([between, [[0.0, 0.3, 0.004]]])
    triangles = np.array([[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 0, 3]])
    flat = (
        triangles[:, [0, 2, 1]] if np.cross(*np.diff(surface[[4, 0, 1]], axis=0))[2] < 0 else None
    )
    found = spread(points, np.array([[1.0, 3.0]]), surface, triangles if flat is None else flat)
    # At a quarter the weights are as 9 to 1.
    np.testing.assert_allclose(found[0, :4], [1.0, 2.0, 1.2, 3.0], atol=1e-6)


def test_what_no_camera_saw_has_no_residual() -> None:
    whole = prediction()
    blind = np.full_like(whole.measured, np.nan)
    made = viewer_of_prediction(
        "plate",
        Prediction(
            TOP, TIME, whole.temperature, blind, {}, PLATE, whole.nodal_time, whole.nodal
        ),
    )  # fmt: skip
    assert [one.name for one in made.layers] == ["temperature"] and made.readings is None
    # One sample that is lost leaves the word to its neighbours.
    lost = whole.measured.copy()
    lost[:, 44] = np.nan
    part = Prediction(TOP, TIME, whole.temperature, lost, {}, PLATE, whole.nodal_time, whole.nodal)
    filled = layer(viewer_of_prediction("plate", part), "residual")
    every = layer(viewer_of_prediction("plate", whole), "residual")
    np.testing.assert_allclose(filled, every, atol=1e-12)


def test_one_sample_speaks_for_its_surroundings() -> None:
    made = viewer_of_prediction("plate", prediction(points=TOP[:1]))
    known = np.isfinite(layer(made, "residual")[0])
    far = np.linalg.norm(made.vertices - TOP[0], axis=1)
    assert 0 < known.sum() < 40 and far[known].max() < 0.012


def test_readings_do_not_speak_beyond_three_spacings() -> None:
    near = TOP[TOP[:, 0] < 0.015]
    made = viewer_of_prediction("plate", prediction(points=near))
    known, x = np.isfinite(layer(made, "residual")[0]), made.vertices[:, 0]
    top = made.vertices[:, 2] == 0.004
    # They lie 4 mm apart, the last of them at 14 mm.
    assert known[top & (x < 0.0251)].all() and not known[x > 0.0261].any()


def field(mesh: Mesh) -> RecoveredField:
    left = mesh.nodes[mesh.faces[:, :3]].mean(axis=1)[:, 0] < 0.02
    cells = np.ones(len(mesh.cells))
    return RecoveredField("conductivity", "W/m/K", cells, np.where(left, 4.0, 1.0))


@pytest.mark.parametrize("divisions", [None, (12, 10, 3)])
def test_a_field_is_on_the_vertices(divisions: tuple[int, int, int] | None) -> None:
    mesh = None if divisions is None else box_mesh((0.04, 0.04, 0.004), divisions)
    found = {"conductivity": field(mesh or PLATE)}
    made = viewer_of_prediction("plate", prediction(), mesh=mesh, fields=found)
    values, x = layer(made, "conductivity")[0], made.vertices[:, 0]
    assert made.layers[-1].unit == "W/m/K" and made.layers[-1].time is None
    assert (values[x < 0.0149] == 4.0).all() and (values[x > 0.0251] == 1.0).all()
    assert ((values >= 1.0 - 1e-12) & (values <= 4.0 + 1e-12)).all()


def test_a_face_takes_the_field_of_one_that_looks_the_same_way() -> None:
    coarse = box_mesh((0.04, 0.04, 0.004), (2, 2, 1))
    upward = np.where(coarse.normals[:, 2] > 0.5, 4.0, 1.0)
    found = RecoveredField("conductivity", "W/m/K", np.ones(len(coarse.cells)), upward)
    fields = {"conductivity": found}
    made = viewer_of_prediction("plate", prediction(), mesh=coarse, fields=fields)
    values, height = layer(made, "conductivity")[0], made.vertices[:, 2]
    # The rim's faces lie nearer to its top's edge than those of the top do.
    inner = (np.abs(made.vertices[:, :2] - 0.02) < 0.0199).all(axis=1)
    np.testing.assert_allclose(values[inner & (height == 0.004)], 4.0)
    np.testing.assert_allclose(values[height < 0.0039], 1.0)


def test_a_field_of_another_mesh_is_refused() -> None:
    other = box_mesh((0.04, 0.04, 0.004), (3, 3, 1))
    with pytest.raises(InputError, match="field conductivity"):
        viewer_of_prediction("plate", prediction(), fields={"conductivity": field(other)})


def test_boundary_triangles_renumber() -> None:
    nodes, triangles = boundary_triangles(PLATE)
    np.testing.assert_array_equal(nodes[triangles], PLATE.faces)

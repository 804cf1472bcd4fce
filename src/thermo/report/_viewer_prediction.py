"""The viewer of a prediction: temperatures, what readings leave, and recovered fields."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.inverse import Prediction, RecoveredField, carry_over
from thermo.mesh import Mesh, nearest_triangle, triangle_normals

from ._viewer import Layer, Readings, Viewer

# Readings that a place between them takes its residual from [1].
_NEIGHBOURS = 3
# How far a reading speaks, in spacings of the readings [1], and least in edges of the mesh.
_SPACINGS, _EDGES = 3.0, 2.0
# What a difference of one between unit normals counts, in reaches [1]: the two sides of a plate,
# whose normals differ by two, stay apart.
_TURN = 0.6


def viewer_of_prediction(
    title: str,
    prediction: Prediction,
    *,
    mesh: Mesh | None = None,
    fields: Mapping[str, RecoveredField] | None = None,
) -> Viewer:
    """The boundary of a prediction's mesh with its temperature, its residual and fields [SI].

    Arguments:

    - `title`: of the page.
    - `prediction`: its `nodal` temperatures [K] at `nodal_time` [s] are shown.
    - `fields`: recovered ones [SI], on the faces of `mesh` [m], the estimate's; of the prediction's
      own mesh where that is left out.

    The residual, simulation less readings [K], is shown at the readings' frames nearest to
    `nodal_time`. Each vertex takes the mean of the three nearest valid samples, weighted by
    1/d^2, where d is the distance along with the turn of the surface between them: one that faces
    the other way counts as 1.2 reaches further. Beyond one reach, three median spacings of the
    samples and at least two edges of the mesh, the residual is not known: readings of one side do
    not speak for the other. There is no such layer where no sample is near any vertex.

    A face takes the field as the simulation did, and gives it to its corners, weighted by area. A
    six-node face is drawn as four triangles.

    Raises `InputError` where a field does not fit the mesh.
    """
    nodes, triangles = boundary_triangles(prediction.mesh)
    vertices = prediction.mesh.nodes[nodes]
    time = prediction.nodal_time
    layers = [Layer("temperature", "K", time, prediction.nodal[:, nodes], "temperature")]
    frames = np.abs(prediction.time - time[:, None]).argmin(axis=1)
    difference = (prediction.temperature - prediction.measured)[frames]
    residual = spread(prediction.points, difference, vertices, triangles)
    if np.isfinite(residual).any():
        layers.append(Layer("residual", "K", time, residual, "residual"))
    fields, own = fields or {}, prediction.mesh
    for field in fields.values():
        _check_fit(field, mesh or own)
    each = len(triangles) // len(own.faces)
    for name, (_, faces) in carry_over(fields, mesh or own, own).items():
        values = _at_vertices(np.repeat(faces, each), vertices, triangles)
        layers.append(Layer(name.replace("_", " "), fields[name].unit, None, values, "field"))
    measured, readings = prediction.measured[frames], None
    if np.isfinite(measured).any():
        readings = Readings(prediction.points, time, measured)
    return Viewer(title, vertices, triangles, tuple(layers), readings)


def boundary_triangles(
    mesh: Mesh,
) -> tuple[Int[np.ndarray, " vertices"], Int[np.ndarray, "triangles 3"]]:
    """Numbers of a mesh's boundary nodes, and its boundary as triangles between these.

    A face with the middles of its edges 01 12 20 becomes four triangles with its turn.
    """
    faces = mesh.faces
    if faces.shape[1] == 6:
        faces = faces[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    nodes, triangles = np.unique(faces, return_inverse=True)
    return nodes, triangles.reshape(-1, 3)


def spread(
    points: Float[np.ndarray, "samples 3"],
    values: Float[np.ndarray, "frames samples"],
    vertices: Float[np.ndarray, "vertices 3"],
    triangles: Int[np.ndarray, "triangles 3"],
) -> Float[np.ndarray, "frames vertices"]:
    """Values of samples [their unit] at `points` [m] brought to vertices [m] of a surface.

    v = sum_k w_k v_k / sum_k w_k with w_k = 1/d_k^2 over the valid ones of the three nearest
    samples, d_k^2 = |x - x_k|^2 + (0.6 r)^2 |n - n_k|^2 [m2], of those with d_k up to the reach
    r; NaN where there is none. A sample's normal n_k is that of the nearest triangle.

    Source: inverse distance weights of D. Shepard, "A two-dimensional interpolation function for
    irregularly-spaced data", 1968.
    """
    reach = _reach(points, vertices, triangles)
    normals, areas = triangle_normals(vertices, triangles)
    at_vertex = _to_vertices(areas[:, None] * normals, triangles, len(vertices))
    at_vertex /= np.maximum(np.linalg.norm(at_vertex, axis=1, keepdims=True), 1e-300)
    face = nearest_triangle(vertices[triangles], points)[0]
    count = min(_NEIGHBOURS, len(points))
    tree = KDTree(np.hstack([points, _TURN * reach * normals[face]]))
    found = tree.query(np.hstack([vertices, _TURN * reach * at_vertex]), k=count)
    far, near = (np.reshape(one, (len(vertices), count)) for one in found)
    # A sample on a vertex outweighs all others, and its weight stays finite.
    weight = np.where(far <= reach, 1.0 / np.maximum(far, 1e-6 * reach) ** 2, 0.0)
    said = values[:, near]
    weights = np.where(np.isfinite(said), weight, 0.0)
    total = weights.sum(axis=2)
    with np.errstate(invalid="ignore"):
        return np.where(total > 0, (weights * np.nan_to_num(said)).sum(axis=2) / total, np.nan)


def _reach(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> float:
    edges = vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]
    least = _EDGES * float(np.median(np.linalg.norm(edges, axis=2)))
    if len(points) < 2:
        return least
    spacing = KDTree(points).query(points, k=2)[0][:, 1]
    return max(least, _SPACINGS * float(np.median(spacing)))


def _to_vertices(values: np.ndarray, triangles: np.ndarray, vertices: int) -> np.ndarray:
    """Sums over the triangles at each vertex."""
    total = np.zeros((vertices, *values.shape[1:]))
    for corner in range(3):
        np.add.at(total, triangles[:, corner], values)
    return total


def _at_vertices(
    values: Float[np.ndarray, " triangles"], vertices: np.ndarray, triangles: np.ndarray
) -> Float[np.ndarray, " vertices"]:
    """Values of triangles [their unit] at their vertices [m], weighted by area."""
    _, areas = triangle_normals(vertices, triangles)
    weighted = _to_vertices(areas * values, triangles, len(vertices))
    return weighted / np.maximum(_to_vertices(areas, triangles, len(vertices)), 1e-300)


def _check_fit(field: RecoveredField, mesh: Mesh) -> None:
    if len(field.faces) != len(mesh.faces):
        raise InputError(
            "the field does not fit the mesh", where=f"field {field.name}",
            value=f"{len(field.faces)} values on faces", limit=f"{len(mesh.faces)} faces",
            remedy="give as `mesh` that of the estimate which holds the field",
        )  # fmt: skip

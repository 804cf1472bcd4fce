"""Bodies as tetrahedra, quadratic functions on them, and points to read."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from scipy.sparse import csr_array
from skfem import Basis, ElementTetP2, FacetBasis, MeshTet

from thermo.mesh import Sizing, read_surface, tetrahedralise

FILES: dict[str, tuple[Path, Path]] = {}
"""Surfaces that are bodies as well, by name, with the folder that keeps their cells."""

LONGEST = 0.05
"""Longest side of a body whose surface is a file [m]."""
EDGES = Sizing(0.0035, 0.006, 0.004, 1e-4)
"""Of its cells [m]; none of a fit's are like these."""


def body_mesh(shape: str, layers: int = 1) -> MeshTet:
    """A body [m], its cells thinner towards the skin, where temperatures vary most.

    `layers`: how many times as many cells lie along z, the way of the lamps [1]; the skin keeps its
    shape.
    """

    def axis(low: float, high: float, cells: int) -> np.ndarray:
        even = np.linspace(-1, 1, cells + 1)
        graded = 0.3 * even + 0.7 * np.sin(np.pi / 2 * even)
        return (low + high) / 2 + (high - low) / 2 * graded

    match shape:
        case "block":
            return MeshTet.init_tensor(
                axis(-0.018, 0.018, 13), axis(-0.013, 0.013, 10), axis(-0.009, 0.009, 6 * layers)
            )
        case "plate":
            return MeshTet.init_tensor(
                axis(-0.025, 0.025, 16), axis(-0.018, 0.018, 12), axis(-0.004, 0.004, 4 * layers)
            )
        case "cylinder":
            mesh = MeshTet.init_tensor(
                axis(-1, 1, 8), axis(-1, 1, 8), axis(-0.02, 0.02, 9 * layers)
            )
            x, y, z = mesh.p
            round_ = np.stack([x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)]) * 0.014
            return MeshTet(np.stack([*round_, z]), mesh.t)
        case "ell":
            ways = axis(-0.02, 0.02, 14), axis(-0.016, 0.016, 12), axis(-0.007, 0.007, 5 * layers)
            mesh = MeshTet.init_tensor(*ways)
            x, y, _ = mesh.p[:, mesh.t].mean(1)
            corner = (x > ways[0][len(ways[0]) // 2]) & (y > ways[1][len(ways[1]) // 3])
            return mesh.remove_elements(np.flatnonzero(corner))
        case "dome":
            mesh = MeshTet.init_tensor(axis(-1, 1, 16), axis(-1, 1, 16), axis(0, 1, 7 * layers))
            x, y, z = mesh.p
            height = 0.006 + 0.012 * np.exp(-1.5 * (x**2 + 0.6 * y**2))
            return MeshTet(np.stack([0.02 * x, 0.017 * y, z * height - 0.008]), mesh.t)
        case "arch":
            mesh = MeshTet.init_tensor(
                axis(-0.018, 0.018, 12), axis(-0.6, 0.6, 14), axis(-1, 1, 6 * layers)
            )
            x, angle, z = mesh.p
            radius = 0.028 + 0.0045 * z
            ring = np.stack([radius * np.sin(angle), radius * np.cos(angle) - 0.028])
            return MeshTet(np.stack([x, *ring]), mesh.t)
        case "wedge":
            mesh = MeshTet.init_tensor(
                axis(-0.022, 0.022, 15), axis(-0.014, 0.014, 10), axis(0, 1, 6 * layers)
            )
            x, y, z = mesh.p
            return MeshTet(np.stack([x, y, 0.006 + (z - 1) * (0.0105 + 0.25 * x)]), mesh.t)
    if shape in FILES:
        return filled(*FILES[shape])
    raise ValueError(f"no body is called {shape}")


@cache
def filled(file: Path, cache: Path) -> MeshTet:
    """A surface about the origin, filled once with unstructured tetrahedra [m]."""
    surface = trimesh.load_mesh(file, process=True)
    surface.apply_translation(-surface.bounds.mean(0))
    surface.apply_scale(LONGEST / surface.extents.max())
    with tempfile.TemporaryDirectory() as folder:
        scaled = Path(folder) / "scaled.ply"
        surface.export(scaled)
        made = tetrahedralise(read_surface(scaled), EDGES, cache=cache)
    return MeshTet(np.ascontiguousarray(made.nodes.T), np.ascontiguousarray(made.cells.T))


@dataclass(frozen=True)
class Body:
    """A mesh with what is needed to put heat equations together on it.

    Sparse matrices take nodal temperatures [K] to values or slopes [K, K/m] at quadrature points,
    whose places [m] and weights [m3, m2] stand beside them.
    """

    mesh: MeshTet
    values: csr_array
    slopes: tuple[csr_array, csr_array, csr_array]
    at: np.ndarray
    weight: np.ndarray
    skin: csr_array
    skin_at: np.ndarray
    skin_normal: np.ndarray
    skin_weight: np.ndarray
    reading: csr_array
    points: np.ndarray
    surface: trimesh.Trimesh


def body(shape: str, samples: int, seed: int, finer: int = 0, layers: int = 1) -> Body:
    """A body with `samples` points on its skin, drawn evenly over the area by a seed [1].

    `finer`: how often the cells at its skin are cut, across their longest edges [1]; `layers`: see
    `body_mesh`. Points and surface are those of the usual cells.
    """
    usual = body_mesh(shape)
    return body_of(usual, samples, seed, finer, body_mesh(shape, layers))


def body_of(
    coarse: MeshTet, samples: int, seed: int, finer: int = 0, cells: MeshTet | None = None
) -> Body:
    """The same for cells [m] of one's own; `cells` in their place within the same skin."""
    mesh = coarse if cells is None else cells
    for _ in range(finer):
        # Across their longest edges: faces stay where they are.
        mesh = mesh.refined(np.unique(mesh.f2t[0, mesh.boundary_facets()]))
    inner = Basis(mesh, ElementTetP2(), intorder=4)
    outer = FacetBasis(mesh, ElementTetP2(), intorder=4)
    surface = _surface(coarse)
    points, faces = trimesh.sample.sample_surface(surface, samples, seed=seed)
    # Seen as lying inside by the search through cells.
    inwards = points - 1e-8 * surface.face_normals[faces]
    return Body(
        mesh,
        _matrix(inner, [one[0].value for one in inner.basis]),
        tuple(_matrix(inner, [one[0].grad[way] for one in inner.basis]) for way in range(3)),
        _flat(inner.global_coordinates().value), inner.dx.ravel(),
        _matrix(outer, [one[0].value for one in outer.basis]),
        _flat(outer.global_coordinates().value), _flat(outer.normals), outer.dx.ravel(),
        csr_array(inner.probes(inwards.T)), points, surface,
    )  # fmt: skip


def _surface(mesh: MeshTet) -> trimesh.Trimesh:
    faces = mesh.facets[:, mesh.boundary_facets()].T
    made = trimesh.Trimesh(mesh.p.T, faces, process=True)
    made.fix_normals()
    made.remove_unreferenced_vertices()
    return made


def _flat(of: np.ndarray) -> np.ndarray:
    """(3, cells, points) as (cells * points, 3)."""
    return np.asarray(of).reshape(3, -1).T


def _matrix(basis: Basis | FacetBasis, parts: list[np.ndarray]) -> csr_array:
    """Rows cell by cell and point by point, columns by node."""
    shape = basis.dx.shape
    rows = np.arange(shape[0] * shape[1])
    found = []
    for number, part in enumerate(parts):
        columns = np.repeat(basis.element_dofs[number], shape[1])
        found.append(np.stack([rows, columns, np.broadcast_to(part, shape).ravel()]))
    row, column, value = np.concatenate(found, 1)
    whole = (len(rows), basis.N)
    return csr_array((value, (row.astype(int), column.astype(int))), shape=whole)

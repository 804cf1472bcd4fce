"""From the values of a field's controls to its values on faces and in cells."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from scipy.spatial import KDTree

from thermo.fields._surface_graph import ControlPoints, surface_vertices
from thermo.mesh import Mesh

NEIGHBOURS = 4


@final
class Extension(eqx.Module):
    """Weights [1] that carry control values to faces and cells; each row sums to one.

    - `face_index`, `face_weight`: (faces, k); `cell_index`, `cell_weight`: (cells, k).
    """

    face_index: Int[Array | np.ndarray, "faces k"]
    face_weight: Float[Array | np.ndarray, "faces k"]
    cell_index: Int[Array | np.ndarray, "cells m"]
    cell_weight: Float[Array | np.ndarray, "cells m"]

    def to_faces(self, controls: Float[Array, " controls"]) -> Float[Array, " faces"]:
        """Values on the faces, in the unit of the controls."""
        return jnp.sum(controls[self.face_index] * self.face_weight, axis=1)

    def to_cells(self, controls: Float[Array, " controls"]) -> Float[Array, " cells"]:
        """Values in the cells, in the unit of the controls."""
        return jnp.sum(controls[self.cell_index] * self.cell_weight, axis=1)


def labelled_extension(
    face_label: Int[np.ndarray, " faces"], cell_label: Int[np.ndarray, " cells"]
) -> Extension:
    """Each face and cell takes the value of one control [1]: uniform or patchwise fields."""
    return Extension(
        face_label[:, None].astype(np.int32),
        np.ones((len(face_label), 1)),
        cell_label[:, None].astype(np.int32),
        np.ones((len(cell_label), 1)),
    )


def uniform_extension(mesh: Mesh) -> Extension:
    """One control for the whole body, whatever its size [m]."""
    return labelled_extension(np.zeros(len(mesh.faces), int), np.zeros(len(mesh.cells), int))


def _behind(mesh: Mesh) -> tuple[Int[np.ndarray, "cells k"], Float[np.ndarray, "cells k"]]:
    """The surface vertices nearest to each cell and their weights."""
    nodes, _ = surface_vertices(mesh)
    centres = mesh.nodes[mesh.cells[:, :4]].mean(1)
    distance, near = KDTree(mesh.nodes[nodes]).query(centres, k=min(3, len(nodes)))
    weight = 1 / np.maximum(distance, 1e-12) ** 2
    return np.asarray(near), weight / weight.sum(1, keepdims=True)


def patch_extension(mesh: Mesh, controls: ControlPoints) -> Extension:
    """Each face and cell takes the value of the control nearest along the surface [m]."""
    _, faces = surface_vertices(mesh)
    owner = controls.distance.argmin(0)
    near, _ = _behind(mesh)
    face_owner = controls.distance[:, faces].mean(2).argmin(0)
    return labelled_extension(face_owner, owner[near[:, 0]])


def interpolating_extension(mesh: Mesh, controls: ControlPoints) -> Extension:
    """Inverse-distance weights [1] of the nearest controls along the surface.

    Surface vertices take weights 1/d^2 of their four nearest controls; a face the mean of its
    vertices; a cell the inverse-distance mean of its three nearest surface vertices, so that what
    lies deep takes the value of the surface above it. Constants are reproduced exactly.

    Source: paper, appendix B.5 (checklist C4, C5).
    """
    _, faces = surface_vertices(mesh)
    keep = min(NEIGHBOURS, len(controls.vertex))
    nearest = np.argsort(controls.distance, axis=0, kind="stable")[:keep].T
    distance = np.take_along_axis(controls.distance.T, nearest, axis=1)
    small = 1e-6 * float(controls.distance.max()) + 1e-12
    weight = 1 / np.maximum(distance, small) ** 2
    weight /= weight.sum(1, keepdims=True)
    near, share = _behind(mesh)
    return Extension(
        face_index=nearest[faces].reshape(len(faces), -1).astype(np.int32),
        face_weight=weight[faces].reshape(len(faces), -1) / 3,
        cell_index=nearest[near].reshape(len(near), -1).astype(np.int32),
        cell_weight=(weight[near] * share[:, :, None]).reshape(len(near), -1),
    )

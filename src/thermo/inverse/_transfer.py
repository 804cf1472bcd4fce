"""Recovered fields on another mesh of the same object."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.fields import two_material_values
from thermo.inverse._estimate import RecoveredField, weighted_quantile
from thermo.inverse._properties import Values
from thermo.mesh import Mesh, Surface, face_areas

# Corners of two meshes of one surface lie this near to each other, over the diagonal [1]: the
# mesher keeps within a thousandth of it.
SAME = 0.01


def check_same_object(old: Mesh, surface: Surface, where: str) -> None:
    """Refuse an estimate whose mesh [m] has not the size and place of a surface [m].

    Raises `InputError`; `where` names the estimate.
    """
    ends = np.array([[p.min(0), p.max(0)] for p in (old.nodes, surface.vertices)])
    diagonal = float(np.linalg.norm(ends[1, 1] - ends[1, 0]))
    apart = float(np.abs(ends[0] - ends[1]).max())
    if apart > SAME * diagonal:
        raise InputError(
            "this estimate is of an object of another size or place",
            where=where,
            value=f"their bounding boxes differ by {1e3 * apart:.3g} mm",
            limit=f"{1e3 * SAME * diagonal:.3g} mm, {SAME:.0%} of the object",
            remedy="give as `data` a scene with the surface that was fitted",
        )


def carry_over(fields: Mapping[str, RecoveredField], old: Mesh, new: Mesh) -> dict[str, Values]:
    """Values of each field on another mesh [m], those of the nearest cell and face.

    Two materials are laid out on the other mesh anew, with the same boundary.

    Faces that look another way count as one edge further for each unit of their normals'
    difference, so that the side of a plate does not speak for the rim of its top.
    """
    cell = KDTree(old.nodes[old.cells[:, :4]].mean(1)).query(new.nodes[new.cells[:, :4]].mean(1))
    edge = float(np.sqrt(2 * face_areas(old).mean()))
    there, here = (
        np.hstack([mesh.nodes[mesh.faces[:, :3]].mean(1), edge * mesh.normals])
        for mesh in (old, new)
    )
    face = KDTree(there).query(here)
    return {
        name: (field.cells[np.asarray(cell[1])], field.faces[np.asarray(face[1])])
        if field.boundary is None
        else two_material_values(field.boundary, new)
        for name, field in fields.items()
    }


def medians(fields: Mapping[str, RecoveredField], old: Mesh, new: Mesh) -> dict[str, Values]:
    """The median of each field over the surface of its mesh [m], on another mesh."""
    areas = face_areas(old)
    middle = {name: weighted_quantile(item.faces, areas, 0.5) for name, item in fields.items()}
    return {
        name: (np.full(len(new.cells), value), np.full(len(new.faces), value))
        for name, value in middle.items()
    }

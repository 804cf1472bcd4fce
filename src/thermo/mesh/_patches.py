"""Choosing boundary faces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from thermo.errors import InputError

from ._mesh import Mesh

Predicate = Callable[
    [Float[np.ndarray, "faces 3"], Float[np.ndarray, "faces 3"]], Bool[np.ndarray, " faces"]
]
"""From face centres [m] and outward unit normals to which faces are meant."""


Direction = Sequence[float | int] | np.ndarray
"""Three numbers along x, y and z."""


def face_centres(mesh: Mesh) -> Float[np.ndarray, "faces 3"]:
    """Centres of the boundary faces [m]."""
    return mesh.nodes[mesh.faces[:, :3]].mean(axis=1)


def faces_where(
    mesh: Mesh, predicate: Predicate, *, where: str = "patch"
) -> Int[np.ndarray, " chosen"]:
    """Numbers of the boundary faces for which `predicate(centres, normals)` holds, ascending.

    Arguments:
    - `predicate`: takes face centres (faces, 3) [m] and unit normals (faces, 3), gives (faces,)
      truth values.
    - `where`: what to call the patch in messages.

    Raises `InputError` where the answer has another shape or no face is meant.
    """
    centres = face_centres(mesh)
    answer = np.asarray(predicate(centres, mesh.normals))
    if answer.shape != (len(mesh.faces),) or answer.dtype != bool:
        raise InputError(
            "the predicate does not answer for every face",
            where=where,
            value=f"shape {answer.shape}, dtype {answer.dtype}",
            limit=f"shape ({len(mesh.faces)},), dtype bool",
            remedy="return one truth value a face",
        )
    chosen = np.flatnonzero(answer)
    if chosen.size == 0:
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        raise InputError(
            "the patch holds no face",
            where=where,
            value="0 faces",
            limit="1 face or more",
            remedy=f"the body spans {low.round(6).tolist()} to {high.round(6).tolist()} m; "
            "enlarge the patch or check its unit",
        )
    return chosen.astype(np.int32)


def faces_in_box(
    mesh: Mesh, low: Direction, high: Direction, *, where: str = "box"
) -> Int[np.ndarray, " chosen"]:
    """Boundary faces whose centre lies in the box from `low` to `high` [m], limits included.

    Raises `InputError` where the box is inside out or holds no face.
    """
    least, most = np.asarray(low, float), np.asarray(high, float)
    if least.shape != (3,) or most.shape != (3,) or not (least <= most).all():
        raise InputError(
            "the box is not a box",
            where=where,
            value=f"{least.tolist()} to {most.tolist()}",
            limit="three lower and three upper limits, lower <= upper",
            remedy="order the limits of each axis",
        )

    def inside(centres: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.all((centres >= least) & (centres <= most), axis=1)

    return faces_where(mesh, inside, where=where)


def faces_towards(
    mesh: Mesh, direction: Direction, cosine: float | int = 0.9, *, where: str = "direction"
) -> Int[np.ndarray, " chosen"]:
    """Boundary faces whose outward normal lies within arccos(`cosine` [1]) of `direction`.

    Raises `InputError` for a direction without length or where no face looks that way.
    """
    along = np.asarray(direction, float)
    length = float(np.linalg.norm(along))
    if along.shape != (3,) or not (np.isfinite(length) and length > 0.0):
        raise InputError(
            "the direction has no length",
            where=where,
            value=along.tolist(),
            limit="three finite numbers, not all 0",
            remedy="give a vector such as (0, 0, 1)",
        )
    return faces_where(mesh, lambda _, normals: normals @ (along / length) >= cosine, where=where)

"""Binding samples to the mesh, once for each recording."""

from __future__ import annotations

import numpy as np

from thermo.mesh import Mesh, locate
from thermo.observe._distance import check_distance
from thermo.observe._recording import Recording
from thermo.physics import ReadOut


def bind(recording: Recording, mesh: Mesh, *, where: str) -> tuple[ReadOut, np.ndarray]:
    """Bind each sample to its nearest boundary face.

    Arguments:

    - `recording`: its points are (samples, 3) [m].
    - `mesh`: the body [m]; quadratic faces are read with their six shape functions.
    - `where`: what messages call the recording.

    Returns the read-out and the distance of each sample from the surface, (samples,) [m]. Raises
    `InputError` where samples lie too far away.

    Source: paper, appendix B.6 (checklist D1, D2).
    """
    place = locate(mesh, recording.points)
    diagonal = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
    check_distance(place.distance, diagonal=diagonal, where=where)
    return ReadOut(place.nodes.astype(np.int32), place.weights), place.distance

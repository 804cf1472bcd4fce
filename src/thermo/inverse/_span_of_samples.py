"""Whether samples are those of an object as large as the surface says."""

from __future__ import annotations

from typing import Final

import numpy as np

from thermo.errors import InputError
from thermo.mesh import Surface, nearest_triangle
from thermo.observe import Recording

# So many samples that span less than this of the object, and lie off it by more than this of what
# they span, root mean square, are those of a smaller one [1].
_MANY: Final = 10
_CORNER: Final = 0.15
_OFF: Final = 0.03


def check_span(recording: Recording, surface: Surface, where: str) -> None:
    """Refuse samples in a corner of an object that lie off its surface by much of what they span.

    Those of a surface in centimetres that is said to be in metres are told by its size; one in
    millimetres that is said to be in centimetres is as large as many an object, and its samples
    near enough to it for its size.

    Arguments: `surface`: the object's [m]; `where`: what messages call the recording.

    Raises `InputError`.
    """
    points = recording.points
    span, diagonal = float(np.linalg.norm(np.ptp(points, axis=0))), surface.diagonal()
    if len(points) < _MANY or span >= _CORNER * diagonal:
        return
    *_, distance = nearest_triangle(surface.vertices[surface.triangles], points)
    off = float(np.sqrt(np.mean(distance**2)))
    if off <= _OFF * span:
        return
    raise InputError(
        "samples lie in a corner of the object and off its surface", where=f"{where}: points",
        value=f"{off:.3g} m off it, root mean square; they span {span:.3g} m, the object "
        f"{diagonal:.3g} m",
        limit=f"{_OFF:.0%} of what they span ({_OFF * span:.3g} m)",
        remedy="check the surface's unit: the object may be smaller than it says; else bring "
        "points and surface to one frame (registration)",
    )  # fmt: skip

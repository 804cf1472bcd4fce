"""Which parts of a surface are bodies and which are cavities."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from thermo.errors import InputError

from ._surface import body_volumes


def winding_number(
    point: Float[np.ndarray, "3"], corners: Float[np.ndarray, "triangles 3 3"]
) -> float:
    """Solid angle of closed triangles seen from a point, over 4 pi: about +-1 inside, 0 outside.

    After van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126.
    """
    a, b, c = (corners[:, i] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    triple = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc
    for x, y, length in ((a, b, lc), (b, c, la), (c, a, lb)):
        below = below + np.einsum("ij,ij->i", x, y) * length
    return float(2.0 * np.arctan2(triple, below).sum() / (4.0 * np.pi))


def outward(
    vertices: Float[np.ndarray, "vertices 3"],
    triangles: Int[np.ndarray, "triangles 3"],
    body: Int[np.ndarray, " triangles"],
    *,
    where: str,
) -> Int[np.ndarray, "triangles 3"]:
    """Turn a consistently turned surface outward.

    A part inside another is a cavity and must turn the other way. A surface that is wrong
    everywhere is turned as a whole.

    Raises `InputError` where a part encloses nothing or only some parts turn the wrong way.
    """
    count = int(body.max()) + 1
    parts = [triangles[body == number] for number in range(count)]
    volumes = np.array([body_volumes(vertices, part).sum() for part in parts])
    size = float(np.linalg.norm(np.ptp(vertices, axis=0))) ** 3
    if np.abs(volumes).min() < 1e-12 * size:
        raise InputError(
            "a part of the surface encloses nothing",
            where=where,
            value=f"part {int(np.argmin(np.abs(volumes))) + 1} of {count}: "
            f"{np.abs(volumes).min():.1e} m3",
            limit="a volume above 0",
            remedy="remove flat and doubled sheets",
        )
    expected = np.ones(count)
    for inner in range(count):
        probe = vertices[parts[inner][0, 0]]
        around = [
            outer
            for outer in range(count)
            if outer != inner and abs(winding_number(probe, vertices[parts[outer]])) > 0.5
        ]
        expected[inner] = -1.0 if len(around) % 2 else 1.0
    wrong = np.sign(volumes) != expected
    if wrong.all():
        return triangles[:, [0, 2, 1]]
    if wrong.any():
        first = int(np.argmax(wrong))
        kind = "cavity" if expected[first] < 0.0 else "body"
        raise InputError(
            f"a {kind} is turned the wrong way",
            where=where,
            value=f"part {first + 1} of {count} ({len(parts[first])} triangles)",
            limit="bodies turned outward, cavities inside them turned inward",
            remedy="flip that part in a mesh editor, or remove it",
        )
    return triangles

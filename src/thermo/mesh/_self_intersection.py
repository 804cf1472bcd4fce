"""Triangles of a surface that pass through each other."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Int

from ._box_tree import overlapping_pairs

MARGIN: Final = 1e-6
"""Share of an edge or triangle next to its ends in which a touch is not taken for a crossing."""

CHUNK: Final = 200000


def crossing_pairs(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles 3"]
) -> Int[np.ndarray, "pairs 2"]:
    """Pairs of triangles of which an edge of one passes through the inside of the other.

    Pairs with a common edge cannot cross. Triangles that merely lie on each other in one plane
    are not reported.

    Arguments: `vertices` [m]; `triangles`: three of them each.
    """
    corners = vertices[triangles]
    pairs = overlapping_pairs(corners)
    shared = np.zeros(len(pairs), int)
    for i in range(3):
        for j in range(3):
            shared += triangles[pairs[:, 0], i] == triangles[pairs[:, 1], j]
    pairs = pairs[shared < 2]
    found = [
        part[_cross(corners[part[:, 0]], corners[part[:, 1]])]
        for part in np.array_split(pairs, len(pairs) // CHUNK + 1)
    ]
    return np.concatenate(found)


def _cross(first: Float[np.ndarray, "pairs 3 3"], second: Float[np.ndarray, "pairs 3 3"]):
    answer = np.zeros(len(first), bool)
    for edge in range(3):
        ends = edge, (edge + 1) % 3
        answer |= _pierces(first[:, ends[0]], first[:, ends[1]], second)
        answer |= _pierces(second[:, ends[0]], second[:, ends[1]], first)
    return answer


def _pierces(
    start: Float[np.ndarray, "pairs 3"],
    end: Float[np.ndarray, "pairs 3"],
    triangle: Float[np.ndarray, "pairs 3 3"],
) -> Bool[np.ndarray, " pairs"]:
    """Whether a segment passes through a triangle, away from the ends and the rim."""
    along = end - start
    u, v = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    across = np.cross(along, v)
    determinant = np.einsum("ij,ij->i", u, across)
    lengths = np.linalg.norm(along, axis=1) * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
    usable = np.abs(determinant) > 1e-9 * lengths
    inverse = 1.0 / np.where(usable, determinant, 1.0)
    offset = start - triangle[:, 0]
    first = np.einsum("ij,ij->i", offset, across) * inverse
    turn = np.cross(offset, u)
    second = np.einsum("ij,ij->i", along, turn) * inverse
    reach = np.einsum("ij,ij->i", v, turn) * inverse
    return (
        usable
        & (first > MARGIN)
        & (second > MARGIN)
        & (first + second < 1.0 - MARGIN)
        & (reach > MARGIN)
        & (reach < 1.0 - MARGIN)
    )

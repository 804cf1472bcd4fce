"""How alike the candidates' effects on the readings are, beside the unknowns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from thermo.discover._scores import ScoreTable, best_of_kinds


def aliases(table: ScoreTable) -> Mapping[str, Mapping[str, float]]:
    """R_ij = |g_i' P g_j| / (n_i n_j) of the best part of each kind, by both kinds' names [1].

    One is an effect that no data of these runs would tell from the other, zero one that does not
    show where the other does. Of strengths that are joint it is the largest cosine between what
    two can do.

    Source: Bjoerck and Golub, Math. Comp. 27 (1973) 579, principal angles.
    """
    best = best_of_kinds(table.scores)
    return {
        one.name(): {
            other.name(): _largest_cosine(table.alike, one.columns, other.columns) for other in best
        }
        for one in best
    }


def _largest_cosine(alike: Float[np.ndarray, "columns columns"], one: slice, other: slice) -> float:
    if one == other:
        return 1.0
    found = _root(alike[one, one]) @ alike[one, other] @ _root(alike[other, other])
    return float(min(np.linalg.norm(found, 2), 1.0))


def _root(of: Float[np.ndarray, "some some"]) -> Float[np.ndarray, "some some"]:
    """The inverse of its root; directions that show nothing have none."""
    values, vectors = np.linalg.eigh(of)
    seen = values > 1e-6 * values.max()
    return (vectors[:, seen] / np.sqrt(values[seen])) @ vectors[:, seen].T

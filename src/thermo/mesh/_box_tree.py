"""Pairs of triangles whose bounding boxes overlap."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int


def _along_curve(centres: Float[np.ndarray, "items 3"]) -> Int[np.ndarray, " items"]:
    """Order along a space-filling curve (interleaved bits), so that neighbours stay together."""
    low, span = centres.min(axis=0), np.ptp(centres, axis=0).max()
    grid = ((centres - low) / (span if span > 0.0 else 1.0) * 1023.0).astype(np.int64)
    key = np.zeros(len(centres), np.int64)
    for bit in range(10):
        for axis in range(3):
            key |= ((grid[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")


def overlapping_pairs(corners: Float[np.ndarray, "items 3 3"]) -> Int[np.ndarray, "pairs 2"]:
    """Pairs (i, j), i != j, each once, of triangles whose axis-aligned boxes touch.

    A binary tree of boxes over the triangles is descended pair by pair, a level at a time.
    """
    order = _along_curve(corners.mean(axis=1))
    depth = max(int(np.ceil(np.log2(len(order)))), 1)
    low = np.full((2**depth, 3), np.inf)
    high = np.full((2**depth, 3), -np.inf)
    low[: len(order)] = corners[order].min(axis=1)
    high[: len(order)] = corners[order].max(axis=1)
    lows, highs = [low], [high]
    for _ in range(depth):
        lows.append(lows[-1].reshape(-1, 2, 3).min(axis=1))
        highs.append(highs[-1].reshape(-1, 2, 3).max(axis=1))
    first, second = np.zeros(1, np.int64), np.zeros(1, np.int64)
    for level in range(depth - 1, -1, -1):
        same = first == second
        a, b, s = first[~same], second[~same], first[same]
        left = np.concatenate([2 * a, 2 * a, 2 * a + 1, 2 * a + 1, 2 * s, 2 * s, 2 * s + 1])
        right = np.concatenate([2 * b, 2 * b + 1, 2 * b, 2 * b + 1, 2 * s, 2 * s + 1, 2 * s + 1])
        touch = (lows[level][left] <= highs[level][right]).all(axis=1)
        touch &= (lows[level][right] <= highs[level][left]).all(axis=1)
        first, second = left[touch], right[touch]
    apart = first != second
    return np.column_stack([order[first[apart]], order[second[apart]]])

"""A body with one inner edge."""

from __future__ import annotations

import numpy as np
import trimesh

from thermo.mesh import Surface


def angled() -> Surface:
    """An L of two legs of 30 by 10 mm, 20 mm long, whose inner edge is at x = z = 10 mm."""
    outline = np.array([[0, 0], [30, 0], [30, 10], [10, 10], [10, 30], [0, 30]]) * 1e-3
    low = np.insert(outline, 1, 0.0, axis=1)
    ring = np.arange(6)
    cap = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    both = np.stack([ring, np.roll(ring, -1)])
    sides = np.concatenate([[*both, both[1] + 6], [both[0], *(both[::-1] + 6)]], axis=1).T
    triangles = np.concatenate([cap, cap[:, ::-1] + 6, sides[:, ::-1]])
    shape = trimesh.Trimesh(np.concatenate([low, low + [0.0, 0.02, 0.0]]), triangles)
    shape.fix_normals()
    assert shape.is_watertight and shape.volume > 0
    return Surface(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64))

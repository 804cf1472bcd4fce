"""Small surfaces made on the spot."""

import numpy as np
import pytest
import trimesh

from thermo.mesh import Surface


def as_surface(shape: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64))


@pytest.fixture
def cube() -> Surface:
    """A 40 mm cube of 192 triangles about the origin."""
    return as_surface(trimesh.creation.box((0.04, 0.04, 0.04)).subdivide().subdivide())


@pytest.fixture
def ball() -> Surface:
    """A 25 mm ball of 320 triangles."""
    return as_surface(trimesh.creation.icosphere(subdivisions=2, radius=0.025))

"""The way of light through a body, where its depth is known."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from thermo.inverse._light_path import dark, light_path
from thermo.mesh import Mesh, box_mesh, mesh_from_cells
from thermo.observe import Heater
from thermo.physics import discretise, volume_rule


def lamp(direction: tuple[float, float, float], centre: tuple[float, float, float]) -> Heater:
    return Heater(
        centre=np.array(centre), direction=np.array(direction), radius=0.01, power=2.0, until=5.0
    )


def step() -> Mesh:
    """A block of 40 x 10 x 20 mm without its upper half where x > 20 mm: a stair of two steps."""
    whole = box_mesh((0.04, 0.01, 0.02), (8, 2, 4))
    middle = whole.nodes[whole.cells].mean(1)
    return mesh_from_cells(whole.nodes, whole.cells[(middle[:, 0] < 0.02) | (middle[:, 2] < 0.01)])


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_depth_below_a_flat_top_is_along_the_light(slope: float) -> None:
    space = discretise(box_mesh((0.03, 0.03, 0.01), (4, 4, 3)))
    light = lamp((slope, 0.0, -1.0), (0.015, 0.015, 0.01))
    at = volume_rule(space, 5).at
    path = light_path(light, space)
    length = np.hypot(1.0, slope)
    wanted = (0.01 - at[..., 2]) * length
    # Where the way begins on a side instead, it is the shorter one.
    from_side = at[..., 0] * length / slope if slope else np.full(at.shape[:2], np.inf)
    below = np.asarray(path.below(at))
    clear = np.asarray((from_side > wanted + 0.012) | (from_side < wanted - 0.012))
    assert clear.sum() > 0.4 * clear.size
    np.testing.assert_allclose(below[clear], np.minimum(wanted, from_side)[clear], atol=1e-9)


def test_each_step_of_a_stair_is_lit_from_its_own_top() -> None:
    space = discretise(step())
    at = np.asarray(volume_rule(space, 5).at)
    path = light_path(lamp((0.0, 0.0, -1.0), (0.02, 0.005, 0.03)), space)
    top = np.where(at[..., 0] < 0.02, 0.02, 0.01)
    np.testing.assert_allclose(path.below(jnp.asarray(at)), top - at[..., 2], atol=1e-9)
    assert np.all(np.asarray(path.lit) == 1.0)


def test_light_is_that_of_the_beam_wherever_it_is() -> None:
    space = discretise(step())
    at = volume_rule(space, 5).at
    light = lamp((0.6, 0.0, -0.8), (0.02, 0.005, 0.02))
    off = np.asarray(at) - light.centre
    apart = np.linalg.norm(np.cross(off, light.direction), axis=-1)
    found = light_path(light, space).light(at)
    np.testing.assert_allclose(found, np.exp(-(apart**2) / (2 * 0.01**2)), rtol=1e-12)
    assert not np.asarray(dark(len(space.mesh.cells)).light(at)).any()


def test_light_that_grazes_a_face_is_as_deep_as_its_way_to_the_middle_of_a_cell() -> None:
    space = discretise(box_mesh((0.03, 0.03, 0.01), (4, 4, 3)))
    # Along the top, which it hardly meets: it enters there all the same on its way to some cells.
    path = light_path(lamp((1.0, 0.0, -0.05), (0.0, 0.015, 0.01)), space)
    middle = jnp.asarray(space.mesh.nodes[space.mesh.cells[:, :4]].mean(1))
    below = np.asarray(path.below(middle[None]))[0]
    way = np.linalg.norm(np.asarray(middle - path.entry), axis=1)
    np.testing.assert_allclose(below, way, atol=1e-12)
    assert below.max() < 0.0301

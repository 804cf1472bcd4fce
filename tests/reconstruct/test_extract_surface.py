"""Closed surfaces from distances of closed form."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.mesh import Surface
from thermo.reconstruct import _extract_surface
from thermo.reconstruct._extract_surface import extract_surface
from thermo.reconstruct._region import Region

REGION = Region(np.array([0.1, -0.2, 0.3]), 0.05)
Distance = Callable[[jax.Array], jax.Array]


@pytest.fixture(scope="module", autouse=True)
def small_chunks() -> Iterator[None]:
    """Coarse grids do not fill a chunk of the usual size, and what is left of it is asked for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_extract_surface, "_CHUNK", 1 << 14)
        yield


def ball(radius: float, centre: tuple[float, float, float] = (0.03, 0.05, -0.02)) -> Distance:
    return lambda places: jnp.linalg.norm(places - jnp.asarray(centre), axis=1) - radius


def ring(places: jax.Array) -> jax.Array:
    flat = jnp.sqrt(places[:, 0] ** 2 + places[:, 1] ** 2 + 1e-18) - 0.5
    return jnp.sqrt(flat**2 + places[:, 2] ** 2) - 0.2


def block(places: jax.Array) -> jax.Array:
    off = jnp.abs(places) - jnp.asarray([0.5, 0.3, 0.4])
    outside = jnp.linalg.norm(jnp.maximum(off, 0.0), axis=1)
    return outside + jnp.minimum(jnp.max(off, axis=1), 0.0)


def shape_of(surface: Surface) -> tuple[float, float]:
    """Area and volume in the region's own unit."""
    return surface.area() / REGION.half**2, surface.volume() / REGION.half**3


@pytest.mark.parametrize(
    ("distance", "area", "volume"),
    [
        (ball(0.6), 4 * np.pi * 0.6**2, 4 / 3 * np.pi * 0.6**3),
        (ring, 4 * np.pi**2 * 0.5 * 0.2, 2 * np.pi**2 * 0.5 * 0.2**2),
    ],
)
def test_area_and_volume_err_by_the_square_of_a_cell(
    distance: Distance, area: float, volume: float
) -> None:
    off = []
    for cells in (16, 32, 64):
        found = shape_of(extract_surface(distance, REGION, cells=cells, triangles=10**6))
        off.append([abs(found[0] / area - 1), abs(found[1] / volume - 1)])
    rates = np.log2(np.asarray(off[:-1]) / np.asarray(off[1:]))
    assert (rates > 1.7).all() and (rates < 2.6).all(), rates
    assert max(off[-1]) < 0.01


def test_vertices_lie_on_the_surface_in_metres_and_turn_outward() -> None:
    surface = extract_surface(ball(0.6), REGION, cells=32, triangles=10**6)
    centre = REGION.centre + REGION.half * np.array([0.03, 0.05, -0.02])
    off = np.linalg.norm(surface.vertices - centre, axis=1) - 0.6 * REGION.half
    # Marching cubes alone leaves (2 / 32)^2 / 8 / 0.6 of half an edge; a step of Newton's less.
    assert np.abs(off).max() < 1e-4 * REGION.half
    assert surface.volume() > 0


def test_a_block_keeps_its_volume_when_it_is_brought_down() -> None:
    surface = extract_surface(block, REGION, cells=64, triangles=2000)
    assert len(surface.triangles) <= 2000
    volume = shape_of(surface)[1]
    assert volume == pytest.approx(8 * 0.5 * 0.3 * 0.4, rel=0.01)


def rough(seed: int) -> Distance:
    """Two thin walls with a hole, as uneven as training leaves them."""
    waves = 25.0 * jax.random.normal(jax.random.key(seed), (40, 3))
    begin = 6.28 * jax.random.uniform(jax.random.key(seed + 100), (40,))

    def wall(off: jax.Array, half: tuple[float, float, float]) -> jax.Array:
        off = jnp.abs(off) - jnp.asarray(half)
        outside = jnp.linalg.norm(jnp.maximum(off, 0.0), axis=1)
        return outside + jnp.minimum(jnp.max(off, axis=1), 0.0)

    @jax.jit
    def distance(places: jax.Array) -> jax.Array:
        low = wall(places - jnp.asarray([0.0, 0.0, -0.4]), (0.7, 0.4, 0.05))
        high = wall(places - jnp.asarray([-0.6, 0.0, 0.0]), (0.05, 0.4, 0.5))
        hole = jnp.linalg.norm(places[:, :2] - jnp.asarray([0.3, 0.0]), axis=1) - 0.15
        smooth = jnp.maximum(jnp.minimum(low, high), -hole)
        return smooth + 0.001 * jnp.sum(jnp.sin(places @ waves.T + begin), axis=1)

    return distance


@pytest.mark.parametrize("seed", [0, 5])
def test_thin_walls_stay_whole_when_they_are_brought_down(seed: int) -> None:
    uneven = rough(seed)
    whole = extract_surface(uneven, REGION, cells=128, triangles=10**6)
    # Quadrics that heed no topology join the sides of these walls, and the surface is refused.
    fewer = _extract_surface._brought_down(whole, REGION, 8000)
    assert len(fewer.triangles) <= 8000
    assert fewer.volume() == pytest.approx(whole.volume(), rel=0.01)


def slit(places: jax.Array) -> jax.Array:
    """A ball with a slit, less than a cell of 64 wide, from one side to its middle."""
    gap = 0.01 - jnp.abs(places[:, 2] + 0.1 * places[:, 0])
    return jnp.maximum(ball(0.6)(places), jnp.minimum(gap, places[:, 0]))


def lens(places: jax.Array) -> jax.Array:
    """What a plane cuts off a ball: 0.08 high at its middle, with a sharp rim."""
    return jnp.maximum(ball(0.6, (0.0, 0.0, 0.0))(places), 0.52 - places[:, 2])


@pytest.mark.parametrize(
    ("distance", "cells", "volume"),
    [
        (slit, 64, 4 / 3 * np.pi * 0.6**3 - 0.01 * np.pi * 0.6**2),
        (lens, 128, np.pi * 0.08**2 * 1.72 / 3),
    ],
)
def test_creases_do_not_fold_the_surface(distance: Distance, cells: int, volume: float) -> None:
    # A step of Newton's method alone makes triangles cross, and the surface would be refused.
    surface = extract_surface(distance, REGION, cells=cells, triangles=10**6)
    # Rim and slit are within a cell.
    assert shape_of(surface)[1] == pytest.approx(volume, rel=0.05)


def test_without_its_packages_it_says_how_to_get_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("thermo.reconstruct._extract_surface.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"thermofield\[photographs\]"):
        extract_surface(ball(0.4), REGION, cells=16)


def test_what_reaches_out_of_the_room_is_cut_off() -> None:
    # Half a ball: below its middle nothing is the object.
    room = REGION.centre + REGION.half * np.array([[-0.9, -0.9, 0.0], [0.9, 0.9, 0.9]])
    region = Region(REGION.centre, REGION.half, room)
    surface = extract_surface(ball(0.6, (0.0, 0.0, 0.0)), region, cells=64, triangles=10**6)
    assert shape_of(surface)[1] == pytest.approx(2 / 3 * np.pi * 0.6**3, rel=0.01)
    assert (surface.vertices >= room[0] - 1e-3 * REGION.half).all()


def test_crumbs_are_left_out() -> None:
    def two(places: jax.Array) -> jax.Array:
        return jnp.minimum(ball(0.4)(places), ball(0.1, (0.7, 0.7, 0.7))(places))

    alone = extract_surface(ball(0.4), REGION, cells=32)
    surface = extract_surface(two, REGION, cells=32)
    assert surface.volume() == pytest.approx(alone.volume(), rel=1e-6)


def test_far_from_the_surface_few_places_are_asked_for() -> None:
    asked = []

    def counted(places: jax.Array) -> jax.Array:
        # The last place is repeated to fill a chunk.
        asked.append(1 + np.diff(np.asarray(places), axis=0).any(axis=1).sum())
        return ball(0.3)(places)

    extract_surface(counted, REGION, cells=128, triangles=10**6)
    assert sum(asked) < 0.5 * 129**3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_without_a_surface_it_says_so(sign: float) -> None:
    with pytest.raises(InputError, match="no surface in the region"):
        extract_surface(lambda places: sign * jnp.ones(len(places)), REGION, cells=16)


def test_a_surface_that_the_border_cuts_is_refused() -> None:
    with pytest.raises(InputError, match="border of the region cuts"):
        extract_surface(ball(0.6, (0.6, 0.0, 0.0)), REGION, cells=32)

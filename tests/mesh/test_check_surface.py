"""Repair and refusal of surfaces."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.mesh import Surface, check_surface

from .conftest import as_surface


def joined(*surfaces: Surface) -> Surface:
    """Several surfaces in one."""
    counts = np.cumsum([0] + [len(s.vertices) for s in surfaces])
    return Surface(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.triangles + n for s, n in zip(surfaces, counts, strict=False)]),
    )


def moved(surface: Surface, shift, scale=1.0, flip=False) -> Surface:
    triangles = surface.triangles[:, ::-1] if flip else surface.triangles
    return Surface(surface.vertices * scale + np.asarray(shift, float), triangles)


def test_an_intact_surface_comes_back_as_it_was(ball):
    checked = check_surface(ball, where="ball")
    np.testing.assert_array_equal(checked.vertices, ball.vertices)
    np.testing.assert_array_equal(checked.triangles, ball.triangles)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_soup_with_mixed_turns_and_doubles_is_repaired(seed):
    rng = np.random.default_rng(seed)
    ball = as_surface(trimesh.creation.icosphere(subdivisions=1, radius=0.025))
    soup = ball.vertices[ball.triangles].reshape(-1, 3)
    triangles = np.arange(len(soup)).reshape(-1, 3)
    flip = rng.random(len(triangles)) < 0.4
    triangles[flip] = triangles[flip][:, ::-1]
    doubled = rng.integers(len(triangles), size=3)
    flat = [[0, 0, 1]]
    triangles = rng.permutation(np.concatenate([triangles, triangles[doubled], flat]))
    checked = check_surface(Surface(soup, triangles), where="soup")
    assert len(checked.vertices) == len(ball.vertices)
    assert len(checked.triangles) == len(ball.triangles)
    assert checked.volume() == pytest.approx(ball.volume())


def test_a_surface_turned_inward_is_turned_outward(cube):
    checked = check_surface(moved(cube, 0, flip=True), where="cube")
    assert checked.volume() == pytest.approx(0.04**3)


@pytest.mark.parametrize("count", [1, 2])
def test_small_holes_are_filled(count):
    ball = as_surface(trimesh.creation.icosphere(subdivisions=3, radius=0.025))
    edge = ball.triangles[0, :2]
    meet = np.isin(ball.triangles, edge).sum(axis=1) == 2
    gone = np.flatnonzero(meet)[:count]
    open_ball = Surface(ball.vertices, np.delete(ball.triangles, gone, axis=0))
    checked = check_surface(open_ball, where="ball")
    assert checked.volume() == pytest.approx(ball.volume(), rel=1e-3)
    as_trimesh = trimesh.Trimesh(checked.vertices, checked.triangles, process=False)
    assert as_trimesh.is_watertight and as_trimesh.is_winding_consistent


def test_a_cavity_is_kept(ball):
    checked = check_surface(joined(ball, moved(ball, 0, 0.5, flip=True)), where="shell")
    assert checked.volume() == pytest.approx(ball.volume() * (1 - 0.5**3))


def test_everything_inward_is_turned_with_its_cavity(ball):
    inward = joined(moved(ball, 0, flip=True), moved(ball, 0, 0.5))
    assert check_surface(inward, where="shell").volume() == pytest.approx(0.875 * ball.volume())


def moebius() -> Surface:
    count, width = 24, 0.004
    angle = 2 * np.pi * np.arange(count) / count
    rim = []
    for side in (-1, 1):
        reach = 0.02 + side * width * np.cos(angle / 2)
        rim.append(
            np.column_stack(
                [reach * np.cos(angle), reach * np.sin(angle), side * width * np.sin(angle / 2)]
            )
        )
    triangles = []
    for i in range(count):
        a, b, c, d = i, i + count, (i + 1) % count, (i + 1) % count + count
        if i == count - 1:
            c, d = d, c
        triangles += [(a, b, c), (b, d, c)]
    return Surface(np.concatenate(rim), np.array(triangles))


def bad_surfaces(cube: Surface, ball: Surface) -> dict[str, tuple[Surface, str]]:
    """Surfaces that must be refused, and a word of the message."""
    nan = cube.vertices.copy()
    nan[3, 1] = np.nan
    infinite = cube.vertices.copy()
    infinite[0, 0] = np.inf
    lid = cube.vertices[cube.triangles][:, :, 2].mean(axis=1) > 0.0199
    fin = np.concatenate([cube.triangles, [[*cube.triangles[0, :2], 60]]])
    flat = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]])
    return {
        "empty": (Surface(np.zeros((0, 3)), np.zeros((0, 3), int)), "empty"),
        "no triangles": (Surface(cube.vertices, np.zeros((0, 3), int)), "empty"),
        "points only": (Surface(cube.vertices, np.zeros((5, 3), int)), "size"),
        "range": (Surface(cube.vertices, cube.triangles + 1), "not there"),
        "nan": (Surface(nan, cube.triangles), "not finite"),
        "infinite": (Surface(infinite, cube.triangles), "not finite"),
        "millimetres": (moved(cube, 0, 1000.0), "unit=mm"),
        "centimetres": (moved(cube, 0, 100.0), "looks like"),
        "tiny": (moved(cube, 0, 1e-3), "size"),
        "open": (Surface(cube.vertices, cube.triangles[~lid]), "open"),
        "fin": (Surface(cube.vertices, fin), "more than two"),
        "one-sided": (moebius(), "one-sided"),
        "sheet": (
            Surface(flat, np.array([[0, 1, 2], [1, 3, 2], [0, 3, 1], [0, 2, 3]])),
            "nothing",
        ),
        "one inside out": (joined(cube, moved(ball, (0.1, 0, 0), flip=True)), "body"),
        "nested": (joined(ball, moved(ball, 0, 0.5)), "cavity"),
        "crossing": (joined(cube, moved(ball, (0.02, 0.003, 0.001))), "through itself"),
    }


NAMES = [
    "empty",
    "no triangles",
    "points only",
    "range",
    "nan",
    "infinite",
    "millimetres",
    "centimetres",
    "tiny",
    "open",
    "fin",
    "one-sided",
    "sheet",
    "one inside out",
    "nested",
    "crossing",
]


@pytest.mark.parametrize("name", NAMES)
def test_bad_surfaces_are_refused_with_file_and_reason(name, cube, ball):
    surface, word = bad_surfaces(cube, ball)[name]
    with pytest.raises(InputError, match=word) as refusal:
        check_surface(surface, where="thing.stl")
    text = str(refusal.value)
    assert "thing.stl" in text and "remedy" in text
    assert len(text.splitlines()) < 8


def test_every_bad_surface_is_tried(cube, ball):
    assert set(bad_surfaces(cube, ball)) == set(NAMES)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0, 0.06), st.integers(0, 2**32 - 1))
def test_two_balls_are_refused_exactly_when_they_cross(gap, seed):
    ball = as_surface(trimesh.creation.icosphere(subdivisions=2, radius=0.02))
    direction = np.random.default_rng(seed).normal(size=3)
    shift = direction / np.linalg.norm(direction) * (gap + 1e-4)
    both = joined(ball, moved(ball, shift))
    # The inscribed polyhedra may miss each other for a little less than two radii.
    if gap < 0.0385:
        with pytest.raises(InputError):
            check_surface(both, where="two")
    elif gap > 0.0401:
        assert check_surface(both, where="two").volume() == pytest.approx(2 * ball.volume())

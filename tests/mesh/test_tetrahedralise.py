"""Meshing by pytetwild, its gate and its cache."""

import os
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.mesh import (
    Fine,
    Sizing,
    Surface,
    box_mesh,
    cell_quality,
    cell_volumes,
    locate,
    tetrahedralise,
)
from thermo.mesh import _tetrahedralise as module
from thermo.mesh._cache import FORMAT, content_key, default_cache, load_cells, save_cells
from thermo.mesh._gate import gated_mesh

COARSE = Sizing(skin=0.008, core=0.014, depth=0.01)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A cache shared by the tests of this file, so that the mesher runs rarely."""
    return tmp_path_factory.mktemp("meshes")


@pytest.fixture
def no_mesher(monkeypatch):
    """Fail where the mesher would run."""

    def refuse(*_):
        raise AssertionError("the mesher ran")

    monkeypatch.setattr(module, "_run_mesher", refuse)


def test_a_cube_is_filled_and_nothing_is_left_behind(cube, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh = tetrahedralise(cube, COARSE, cache=folder)
    assert os.listdir(tmp_path) == []
    assert mesh.order == 1 and (cell_volumes(mesh) > 0).all()
    assert mesh.volume() == pytest.approx(0.04**3, rel=2e-3)
    assert cell_quality(mesh).min() > 0.03
    assert locate(mesh, cube.vertices).distance.max() < 1e-4


def test_a_graded_ball_is_finer_at_the_skin(ball, folder):
    graded = Sizing(skin=0.004, core=0.014, depth=0.01)
    meshes = (tetrahedralise(ball, graded, cache=folder / str(trial)) for trial in range(3))
    # The mesher is not reproducible: of 39 meshes 38 gave ratios of 0.41 to 0.62, 37 of these 49 to
    # 103 cells in the core, and one, where it had ended early, a ratio of 0.86; sixteen of one size
    # gave 0.81 to 0.96 and 617 to 999. So it may try three times.
    assert any(_has_a_coarse_core(mesh, ball) for mesh in meshes)


def _has_a_coarse_core(mesh, ball):
    assert mesh.volume() == pytest.approx(ball.volume(), rel=5e-3)
    centres = np.linalg.norm(mesh.nodes[mesh.cells].mean(axis=1), axis=1)
    size = np.cbrt(cell_volumes(mesh))
    in_core = centres < 0.012
    regular = 4 / 3 * np.pi * 0.012**3 / (0.004**3 / (6 * np.sqrt(2)))
    finer = size[centres > 0.02].mean() < 0.75 * size[in_core].mean()
    return finer and in_core.sum() < 0.4 * regular


def test_cells_are_small_where_that_is_asked_for(cube, folder):
    rng = np.random.default_rng(0)
    spots = rng.normal(size=(200, 3))
    spots *= 0.006 / np.linalg.norm(spots, axis=1, keepdims=True)
    mesh = tetrahedralise(cube, replace(COARSE, fine=(Fine(spots, 0.0025),)), cache=folder)
    # Nodes are brought to the surface, but not one whose move would spoil a cell.
    assert mesh.volume() == pytest.approx(0.04**3, rel=2e-3)

    there = np.linalg.norm(mesh.nodes[mesh.cells].mean(axis=1), axis=1) < 0.009
    # Twenty meshes of no such wish had 16 to 36 cells there, sixty of edges of 3 mm 53 to 428.
    assert there.sum() > 40


@pytest.mark.parametrize(
    ("edges", "asked", "kept"),
    [
        # The first whose edges are at most 2.2 times as long as wanted, or the best of four.
        ([2.1], 1, 2.1), ([5.0, 2.0], 2, 2.0), ([5.0, 3.0, 4.0, 6.0, 1.0], 4, 3.0),
    ],
)  # fmt: skip
def test_the_mesher_is_asked_again_until_cells_are_small(cube, monkeypatch, edges, asked, kept):
    corners = np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / np.sqrt(2)
    wanted, seen = 1e-3, []

    def mesher(surface, sizing, longest, time_limit, where):
        seen.append((sizing.fine[0].edge, longest))
        return wanted * edges[len(seen) - 1] * corners, np.array([[0, 1, 2, 3]])

    monkeypatch.setattr(module, "_run_mesher", mesher)
    sizing = replace(COARSE, fine=(Fine(np.zeros((3, 3)), wanted),))
    nodes, _ = module._small_enough(cube, sizing, 1.0, "cube")
    assert np.linalg.norm(nodes[1] - nodes[0]) == pytest.approx(wanted * kept)
    # Each time for shorter edges there, from points that lie closer.
    assert seen == [
        (pytest.approx(wanted * 0.6**k), pytest.approx(COARSE.core * 0.7**k)) for k in range(asked)
    ]


@pytest.mark.parametrize(("body", "simplified"), [("cube", False), ("ball", True)])
def test_within_flat_faces_the_mesher_need_not_look_for_what_to_take_off(
    body, simplified, request, tmp_path, monkeypatch
):
    seen = []

    def run(command, **_):
        with np.load(command[2], allow_pickle=False) as told:
            seen.append(bool(told["simplify"]))
        raise subprocess.TimeoutExpired(command, 1.0)

    monkeypatch.setattr(module.subprocess, "run", run)
    with pytest.raises(InputError, match="did not finish"):
        tetrahedralise(request.getfixturevalue(body), COARSE, cache=tmp_path)
    assert seen == [simplified]


def test_without_a_place_for_small_cells_the_mesher_is_asked_once(cube, monkeypatch):
    seen = []

    def mesher(*asked):
        seen.append(asked)
        return np.zeros((4, 3)), np.array([[0, 1, 2, 3]])

    monkeypatch.setattr(module, "_run_mesher", mesher)
    module._small_enough(cube, COARSE, 1.0, "cube")
    assert len(seen) == 1 and seen[0][2] == COARSE.core


def test_of_two_processes_that_mesh_one_body_the_first_mesh_counts(
    cube, folder, tmp_path, monkeypatch
):
    first = tetrahedralise(cube, COARSE, cache=folder)
    entry = next(path.name for path in folder.glob("*.npz") if load_cells(path) is not None
                 and len(load_cells(path)[0]) == len(first.nodes))  # fmt: skip
    other = first.nodes + 1e-6 * np.sin(1e3 * first.nodes)

    def meanwhile(*_):
        save_cells(tmp_path / entry, first.nodes, first.cells)
        return other, first.cells

    monkeypatch.setattr(module, "_run_mesher", meanwhile)
    mesh = tetrahedralise(cube, COARSE, cache=tmp_path)
    np.testing.assert_array_equal(mesh.nodes, first.nodes)
    assert [path.name for path in tmp_path.iterdir()] == [entry]


def test_a_second_call_reads_the_cache(cube, folder, no_mesher):
    again = tetrahedralise(cube, COARSE, cache=folder)
    assert len(list(folder.glob("*.npz"))) >= 1 and not list(folder.glob("*.part"))
    twice = tetrahedralise(cube, COARSE, cache=folder)
    np.testing.assert_array_equal(again.nodes, twice.nodes)
    np.testing.assert_array_equal(again.cells, twice.cells)


def fake_mesher(monkeypatch, nodes, cells):
    calls = []

    def make(*_):
        calls.append(1)
        return nodes, cells

    monkeypatch.setattr(module, "_run_mesher", make)
    return calls


@pytest.fixture
def made():
    """A mesh of the 40 mm cube that no mesher made."""
    mesh = box_mesh((0.04, 0.04, 0.04), (2, 2, 2), origin=(-0.02, -0.02, -0.02))
    return mesh.nodes, mesh.cells


def damaged_entries(nodes, cells):
    """What may lie in the cache in place of an entry."""
    from io import BytesIO

    stream = BytesIO()
    np.savez(stream, format=np.array(FORMAT), nodes=nodes, cells=cells)
    whole = stream.getvalue()
    stream = BytesIO()
    np.savez(stream, format=np.array("another/9"), nodes=nodes, cells=cells)
    other = stream.getvalue()
    stream = BytesIO()
    pickled = np.array([{"a": 1}], dtype=object)
    np.savez(stream, format=np.array(FORMAT), nodes=pickled, cells=cells)
    unsafe = stream.getvalue()
    stream = BytesIO()
    np.savez(stream, format=np.array(FORMAT), nodes=2.0 * nodes, cells=cells)
    wrong = stream.getvalue()
    return {
        "cut": whole[: len(whole) // 2],
        "empty": b"",
        "noise": b"x" * 500,
        "other": other,
        "pickled": unsafe,
        "wrong size": wrong,
    }


@pytest.mark.parametrize("kind", ["cut", "empty", "noise", "other", "pickled", "wrong size"])
def test_damaged_entries_are_made_again(cube, tmp_path, monkeypatch, made, kind):
    calls = fake_mesher(monkeypatch, *made)
    tetrahedralise(cube, COARSE, cache=tmp_path)
    (entry,) = tmp_path.glob("*.npz")
    entry.write_bytes(damaged_entries(*made)[kind])
    mesh = tetrahedralise(cube, COARSE, cache=tmp_path)
    assert len(calls) == 2 and mesh.volume() == pytest.approx(0.04**3)
    tetrahedralise(cube, COARSE, cache=tmp_path)
    assert len(calls) == 2


def test_a_cache_that_cannot_be_written_is_passed_over(cube, tmp_path, monkeypatch, made):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    fake_mesher(monkeypatch, *made)
    assert len(tetrahedralise(cube, COARSE, cache=blocked / "meshes").cells) == 48
    assert blocked.read_text() == "in the way"


def test_default_cache_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_cache() == tmp_path / "thermofield" / "meshes"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/somewhere")
    assert str(default_cache()) == "/somewhere/.cache/thermofield/meshes"


def test_the_key_depends_on_all_that_matters(cube, ball):
    keys = {
        content_key(cube, COARSE, (1.0,)),
        content_key(ball, COARSE, (1.0,)),
        content_key(cube, COARSE, (2.0,)),
        content_key(cube, Sizing(0.008, 0.014, 0.011), (1.0,)),
        content_key(Surface(cube.vertices * 1.001, cube.triangles), COARSE, (1.0,)),
        *(
            content_key(cube, replace(COARSE, fine=(Fine(np.full((1, 3), at), edge),)), (1.0,))
            for at, edge in ((0.0, 1e-3), (0.0, 2e-3), (0.01, 1e-3))
        ),
    }
    assert len(keys) == 8
    copied = Surface(cube.vertices.copy(), cube.triangles.astype(np.int32))
    assert content_key(copied, COARSE, (1.0,)) in keys


def test_entries_round_trip(tmp_path, made):
    entry = tmp_path / "deep" / "entry.npz"
    assert load_cells(entry) is None
    save_cells(entry, *made)
    kept = load_cells(entry)
    assert kept is not None
    np.testing.assert_array_equal(kept[0], made[0])
    np.testing.assert_array_equal(kept[1], made[1])


@pytest.mark.parametrize(("tilt", "parallel"), [(0.03, True), (0.3, False)])
def test_faces_that_hardly_tilt_are_as_parallel_to_a_wall_as_they_are_meant_to_be(
    cube: Surface, made: tuple[np.ndarray, np.ndarray], tilt: float, parallel: bool
) -> None:
    nodes, cells = made
    # Nodes in the middle of sides are moved along an axis, out of one side and into the other.
    middle = (nodes.min(0) + nodes.max(0)) / 2
    side = np.ptp(nodes, axis=0)[0]
    away = np.abs(nodes - middle)
    in_a_side = (np.isclose(away, side / 2).sum(1) == 1) & (np.isclose(away, 0).sum(1) == 2)
    assert in_a_side.sum() == 6
    moved = nodes + in_a_side[:, None] * tilt * away
    mesh = gated_mesh(moved, cells, cube, where="cube")
    assert (np.abs(mesh.normals).max(axis=1) > 1 - 1e-12).all() == parallel
    a, b, c = (mesh.nodes[mesh.faces[:, i]] for i in range(3))
    own = np.cross(b - a, c - a)
    assert (np.abs(own).max(1) < (1 - 1e-6) * np.linalg.norm(own, axis=1)).any()


def test_the_gate_refuses_empty_flat_and_shrunken_meshes(cube, made):
    nodes, cells = made
    assert len(gated_mesh(nodes, cells, cube, where="cube").cells) == 48
    with pytest.raises(InputError, match="no inside"):
        gated_mesh(nodes, cells[:0], cube, where="cube")
    with pytest.raises(InputError, match="does not fill"):
        gated_mesh(0.99 * nodes, cells, cube, where="cube")
    with pytest.raises(InputError, match="flat"):
        moved = nodes.copy()
        moved[np.linalg.norm(nodes, axis=1) < 1e-9] = [0.0199, 0.0, 0.0]
        gated_mesh(moved, cells, cube, where="cube")


def test_a_mesher_that_takes_too_long_is_stopped(cube, tmp_path):
    with pytest.raises(InputError, match="did not finish"):
        tetrahedralise(cube, COARSE, cache=tmp_path, time_limit=0.01)
    assert list(tmp_path.iterdir()) == []


def test_a_mesher_that_fails_is_reported(cube, tmp_path, monkeypatch):
    child = tmp_path / "child.py"
    child.write_text("raise SystemExit('no memory left')")
    monkeypatch.setattr(module._mesher_child, "__file__", str(child))
    with pytest.raises(InputError, match="no memory left"):
        tetrahedralise(cube, COARSE, cache=tmp_path / "cache")


def test_one_entry_is_read_at_a_time(tmp_path, monkeypatch):
    # Python's parser, which reads headers of arrays, fails at times in two threads at once.
    made = box_mesh((0.02, 0.02, 0.02), (1, 1, 1))
    for name in "ab":
        save_cells(tmp_path / name, made.nodes, made.cells)
    load, busy, most = np.load, [0], [0]

    @contextmanager
    def slowly(*given, **how):
        # Headers are read as arrays are taken, not as the archive is opened.
        with load(*given, **how) as archive:
            busy[0] += 1
            most[0] = max(most[0], busy[0])
            time.sleep(0.05)
            yield archive
            busy[0] -= 1

    monkeypatch.setattr(np, "load", slowly)
    with ThreadPoolExecutor(2) as pool:
        kept = list(pool.map(load_cells, (tmp_path / "a", tmp_path / "b")))
    assert most == [1] and all(one is not None for one in kept)

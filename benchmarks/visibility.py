"""What the paper's depth rule keeps and drops wrongly, against exact ray casting.

    python benchmarks/visibility.py SCENES [--views 24] [--points 20000] [--steepest]

SCENES holds the scenes `bunny`, `car`, `bear` and `bracket`, each with a `surface.ply`; the rule's
one constant, the cosine below which a tolerance grows no more, was chosen on the first two:
`--steepest` prints what others keep and drop, and writes nothing. Cameras of 320 x 240 and
640 x 480 pixels stand round each, spread evenly over a sphere, close enough that the object fills
most of the frame. Points are drawn evenly over the surface. For each object, size and view:
`kept`, how many points the rule |z - D(u, v)| < eps keeps; `false keep`, how many of these are
hidden, over those that are kept; `false drop`, how many of those that are seen are dropped, over
those that are seen. The paper states no eps: `depth_tolerance` derives one for each point. `plain`
is the false keep of the nearest pixel alone, without what the four pixels round a point see. Leaves
benchmarks/results/visibility.csv.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh

from thermo.imaging import (
    Camera,
    _visibility,
    depth_at,
    depth_tolerance,
    look,
    looking_at,
    project,
    seen_by_depth,
    seen_exactly,
)
from thermo.mesh import Surface, read_surface

RESULTS = Path(__file__).resolve().parent / "results" / "visibility.csv"
OBJECTS = ("bunny", "car", "bear", "bracket")
SIZES = ((320, 240), (640, 480))
COLUMNS = (
    "object", "width", "height", "view", "points", "seen", "kept", "false keep", "false drop",
    "plain",
)  # fmt: skip
BAR = 0.01
COSINES = (0.05, 0.1, 0.15, 0.2, 0.25, 0.35, 0.5)


def places(count: int) -> Iterator[np.ndarray]:
    """Directions spread evenly over a sphere, by the golden angle."""
    for number in range(count):
        height = 1 - (2 * number + 1) / count
        turn = np.pi * (3 - np.sqrt(5)) * number
        flat = np.sqrt(1 - height**2)
        yield np.array([flat * np.cos(turn), flat * np.sin(turn), height])


def camera_at(direction: np.ndarray, surface: Surface, size: tuple[int, int]) -> Camera:
    """A camera at 2.5 diagonals from the middle, whose frame is as high as the object is long."""
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    away = 2.5 * surface.diagonal()
    up = np.array([0.0, 1.0, 0.0]) if abs(direction[1]) < 0.95 else np.array([1.0, 0.0, 0.0])
    pose = looking_at(middle + away * direction, middle, up)
    focal = 0.9 * size[1] * away / surface.diagonal()
    return Camera(*size, [focal, focal], [(size[0] - 1) / 2, (size[1] - 1) / 2], pose)


def compared(
    camera: Camera, surface: Surface, points: np.ndarray, normals: np.ndarray
) -> tuple[int, int, float, float, float]:
    """Seen, kept, false keep, false drop, and false keep of the nearest pixel alone."""
    pixel_map = look(camera, surface)
    exact = seen_exactly(camera, surface, points, normals=normals)
    kept = seen_by_depth(pixel_map, camera, surface, points, normals=normals)
    pixels, depth = project(camera, points)
    near = np.abs(depth - depth_at(pixel_map, pixels)) < depth_tolerance(camera, points, normals)
    near &= np.einsum("ij,ij->i", normals, camera.place() - points) > 0
    return (
        int(exact.sum()), int(kept.sum()), (kept & ~exact).sum() / kept.sum(),
        (exact & ~kept).sum() / exact.sum(), (near & ~exact).sum() / near.sum(),
    )  # fmt: skip


def placed(surface: Surface, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points drawn evenly over a surface [m], and normals there."""
    mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    drawn, face = trimesh.sample.sample_surface(mesh, count, seed=0)[:2]
    return np.asarray(drawn), np.asarray(mesh.face_normals)[face]


def steepest(scenes: Path, views: int, count: int) -> None:
    """Print what the rule keeps and drops wrongly for several of its constants."""
    for name in OBJECTS:
        surface = read_surface(scenes / name / "surface.ply")
        points, normals = placed(surface, count)
        cameras = [camera_at(one, surface, SIZES[0]) for one in places(views)]
        for cosine in COSINES:
            _visibility._STEEPEST = cosine
            part = [compared(camera, surface, points, normals)[2:4] for camera in cameras]
            keep, drop = np.transpose(part)
            print(
                f"{name:8} cosine {cosine:.2f}: false keep {keep.mean():.2%}, at most "
                f"{keep.max():.2%}; false drop {drop.mean():.1%}, at most {drop.max():.1%}",
                flush=True,
            )


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--views", type=int, default=24)
    parser.add_argument("--points", type=int, default=20000)
    parser.add_argument("--steepest", action="store_true")
    arguments = parser.parse_args()
    if arguments.steepest:
        steepest(arguments.scenes, arguments.views, arguments.points)
        return
    rows = []
    for name in OBJECTS:
        surface = read_surface(arguments.scenes / name / "surface.ply")
        points, normals = placed(surface, arguments.points)
        for size in SIZES:
            part = []
            for view, direction in enumerate(places(arguments.views)):
                camera = camera_at(direction, surface, size)
                part.append(compared(camera, surface, points, normals))
                told = [f"{one:.5f}" for one in part[-1][2:]]
                rows.append((name, *size, view, len(points), *part[-1][:2], *told))
            keep, drop, plain = (np.array([one[i] for one in part]) for i in (2, 3, 4))
            print(
                f"{name:6} {size[0]} x {size[1]}: false keep {keep.mean():.2%}, at most "
                f"{keep.max():.2%} ({'within' if keep.max() < BAR else 'ABOVE'} {BAR:.0%}); "
                f"false drop {drop.mean():.1%}, at most {drop.max():.1%}; "
                f"plain rule's false keep {plain.mean():.2%}, at most {plain.max():.2%}",
                flush=True,
            )
    with RESULTS.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()

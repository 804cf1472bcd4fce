"""Photographs of a known surface, and how far a surface rebuilt from them is from it.

    python benchmarks/photographed.py FOLDER [--object bunny] [--data FOLDER]

writes the photographs of one object, PNG with alpha, and their `transforms.json`, for `thermo
reconstruct`. Other benchmarks import the functions below.

32 cameras stand around the object on three rings, above and below it; four more, between the
rings, are left out of any training. A pixel is the mean of 4 x 4 rays, cast by embree and not by
what is trained. The surface reflects diffusely, its reflectance a sum of waves of four lengths in
three dimensions; light comes from all sides, more from above, and there are no shadows.

The objects are not in the repository: --data, or the environment variable THERMOFIELD_DATA, names
the folder that holds `geometry`; `data` in the repository's root otherwise.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import trimesh
from jaxtyping import Float
from PIL import Image

from thermo.imaging import (
    Camera,
    View,
    looking_at,
    overlap,
    pixel_centres,
    rays,
    silhouette,
    write_transforms,
)
from thermo.mesh import Surface, nearest_triangle
from thermo.reconstruct import Photograph

ROOT = Path(__file__).resolve().parents[1]
FILES: Final = {"bunny": "bunny.off", "bear": "bear.off", "bracket": "bracket.ply"}
LONGEST: Final = 0.06
"""Longest side of the bunny and the bear [m], as in `scenes`; the bracket's file is in metres."""
RINGS: Final = ((3.0, 10), (38.0, 10), (-33.0, 10), (87.0, 1), (-86.0, 1))
"""Elevation [deg] and number of cameras of each ring; no edge of a box lies along a pixel's."""
LEFT_OUT: Final = ((18.0, 17.0), (108.0, -17.0), (198.0, 60.0), (288.0, -60.0))
"""Azimuth and elevation [deg] of the views that nothing is trained on."""
PIXELS: Final = 128
AWAY: Final = 5.0
"""Distance of the cameras over the radius of the ball about the object [1]."""
FILLED: Final = 0.9
"""Diameter of that ball over the picture's edge [1]."""
WAVES: Final = (0.6, 0.3, 0.15, 0.075)
"""Lengths of the waves of the reflectance over the box's diagonal [1]; a pixel is about 0.01."""
SAMPLES: Final = 50_000


class Photographed(NamedTuple):
    """Photographs to rebuild a surface from, others to judge it by, and the surface itself [m]."""

    photographs: tuple[Photograph, ...]
    left_out: tuple[Photograph, ...]
    truth: trimesh.Trimesh


class SurfaceError(NamedTuple):
    """How far a surface is from the true one.

    - `distance`: mean of the mean distances from one to the other and back [m].
    - `share`: that over the diagonal of the true one's box [1].
    - `volume`: its volume over the true one's [1].
    """

    distance: float
    share: float
    volume: float


def data_folder(given: Path | None) -> Path:
    """The folder of the objects; ends the program where it holds none."""
    data = given or Path(os.environ.get("THERMOFIELD_DATA", ROOT / "data"))
    if not (data / "geometry").is_dir():
        sys.exit(f"no geometry in {data}: give --data FOLDER or set THERMOFIELD_DATA")
    return data


def true_surface(name: str, data: Path) -> trimesh.Trimesh:
    """The surface of `bunny`, `bear` or `bracket` [m], the middle of its box at the origin."""
    mesh = trimesh.load_mesh(data / "geometry" / FILES[name])
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    if name != "bracket":
        mesh.apply_scale(LONGEST / mesh.extents.max())
    return mesh


def photographed(name: str, data: Path) -> Photographed:
    """Photographs of `bunny`, `bear` or `bracket`."""
    return photographs_of(true_surface(name, data))


def photographs_of(mesh: trimesh.Trimesh, *, pixels: int = PIXELS) -> Photographed:
    """Photographs of any closed surface [m], `pixels` wide and high."""
    around = [
        # Rings are turned against each other, so that no two cameras stand above one another.
        (7.0 + 360.0 * (number + ring / 3) / count, elevation)
        for ring, (elevation, count) in enumerate(RINGS)
        for number in range(count)
    ]
    seen = tuple(
        photograph(mesh, stood(mesh, place, pixels, f"view_{number:02d}"))
        for number, place in enumerate(around)
    )
    left = tuple(
        photograph(mesh, stood(mesh, place, pixels, f"left_out_{number}"))
        for number, place in enumerate(LEFT_OUT)
    )
    return Photographed(seen, left, mesh)


def stood(mesh: trimesh.Trimesh, place: tuple[float, float], pixels: int, name: str) -> Camera:
    """A camera at azimuth and elevation [deg] that looks at the middle of the box."""
    azimuth, elevation = np.radians(place)
    flat = np.cos(elevation)
    way = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
    up = np.array([0.0, 1.0, 0.0] if abs(way[2]) > 0.99 else [0.0, 0.0, 1.0])
    middle = mesh.bounds.mean(axis=0)
    radius = np.linalg.norm(mesh.vertices - middle, axis=1).max()
    pose = looking_at(middle + AWAY * radius * way, middle, up)
    focal = 0.5 * FILLED * pixels * np.sqrt(AWAY**2 - 1)
    centre = (pixels - 1) / 2
    return Camera(pixels, pixels, (focal, focal), (centre, centre), pose, name=name)


def photograph(mesh: trimesh.Trimesh, camera: Camera) -> Photograph:
    """What a camera sees: the covered part's colour, eight bits a channel, and the share covered.

    The colour of a pixel is that of its covered part alone, as in a PNG with alpha; black where
    nothing is covered.
    """
    middle, size = mesh.bounds.mean(axis=0), np.linalg.norm(mesh.extents)
    # Embree counts in single precision: lengths over the size, about the middle.
    unit = trimesh.Trimesh((mesh.vertices - middle) / size, mesh.faces, process=False)
    place = (camera.place() - middle) / size
    steps = (np.arange(4) - 1.5) / 4
    light = np.zeros((camera.width * camera.height, 3))
    part = np.zeros(len(light))
    for step in np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2):
        lines = rays(camera, pixel_centres(camera) + step)
        hit, colour = _met(unit, place, lines)
        light[hit] += colour / len(steps) ** 2
        part[hit] += 1 / len(steps) ** 2
    linear = light / np.maximum(part, 1e-9)[:, None]
    shape = (camera.height, camera.width)
    return Photograph(
        camera=camera,
        colour=_eight_bits(_srgb(linear)).reshape(*shape, 3) * (part > 0).reshape(*shape, 1),
        mask=_eight_bits(part).reshape(shape),
        file=f"images/{camera.name}.png",
    )


def reflectance(points: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
    """Linear red, green and blue, 0.04 to 0.8 [1], at points over the diagonal [1]."""
    random = np.random.default_rng(20)
    total = np.zeros((len(points), 3))
    for length in WAVES:
        for channel in range(3):
            ways = random.normal(size=(4, 3))
            ways *= 2 * np.pi / length / np.linalg.norm(ways, axis=1, keepdims=True)
            begin = random.uniform(0, 2 * np.pi, 4)
            total[:, channel] += np.sin(points @ ways.T + begin).sum(axis=1) / np.sqrt(8)
    return 0.04 + 0.76 / (1 + np.exp(-1.2 * total))


def surface_error(surface: trimesh.Trimesh, truth: trimesh.Trimesh) -> SurfaceError:
    """How far a surface [m] is from the true one [m], by points spread evenly over both."""
    there = _distance(surface, truth, seed=0)
    back = _distance(truth, surface, seed=1)
    distance = (there + back) / 2
    return SurfaceError(
        distance,
        float(distance / np.linalg.norm(truth.extents)),
        float(surface.volume / truth.volume),
    )


def silhouette_iou(surface: trimesh.Trimesh, photograph: Photograph) -> float:
    """Overlap of the silhouette of a surface [m] with the mask of a photograph, cut at half [1]."""
    shape = Surface(np.asarray(surface.vertices, float), np.asarray(surface.faces))
    return overlap(silhouette(photograph.camera, shape), photograph.mask > 0.5)


def write_photographs(folder: Path, photographs: tuple[Photograph, ...]) -> None:
    """Leave pictures with alpha, and their cameras in `transforms.json`, in a folder."""
    for one in photographs:
        path = folder / one.file
        path.parent.mkdir(parents=True, exist_ok=True)
        picture = np.concatenate([one.colour, one.mask[..., None]], axis=2)
        Image.fromarray(np.round(255 * picture).astype(np.uint8), "RGBA").save(path)
    write_transforms(
        folder / "transforms.json", [View(one.camera, one.file) for one in photographs]
    )


def _met(
    mesh: trimesh.Trimesh, place: np.ndarray, lines: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which lines of sight meet the surface, and the linear colour that they see there [1]."""
    triangle = mesh.ray.intersects_first(np.tile(place, (len(lines), 1)), lines)
    hit = np.flatnonzero(triangle >= 0)
    corners, normal = mesh.triangles[triangle[hit]], mesh.face_normals[triangle[hit]]
    along = np.einsum("ij,ij->i", corners[:, 0] - place, normal)
    along /= np.einsum("ij,ij->i", lines[hit], normal)
    points = place + along[:, None] * lines[hit]
    # Seen edge on, the plane is met anywhere; the triangle is not.
    points = np.clip(points, corners.min(axis=1), corners.max(axis=1))
    lit = 0.7 + 0.3 * normal[:, 2:]
    return hit, reflectance(points) * lit


def _distance(one: trimesh.Trimesh, other: trimesh.Trimesh, seed: int) -> float:
    points, _ = trimesh.sample.sample_surface(one, SAMPLES, seed=seed)
    return float(nearest_triangle(np.asarray(other.triangles), np.asarray(points))[2].mean())


def _srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _eight_bits(values: np.ndarray) -> np.ndarray:
    return np.round(255 * values) / 255


def main() -> None:
    """Write the photographs of one object."""
    parser = argparse.ArgumentParser(description="Photographs of a known surface.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--object", default="bunny", choices=FILES)
    parser.add_argument("--data", type=Path, help="folder that holds geometry")
    given = parser.parse_args()
    made = photographed(given.object, data_folder(given.data))
    write_photographs(given.folder, made.photographs)
    made.truth.export(given.folder / "truth.ply")
    print(f"{len(made.photographs)} photographs in {given.folder}")


if __name__ == "__main__":
    main()

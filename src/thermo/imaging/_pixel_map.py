"""What each pixel of a camera sees of a surface."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int

from thermo.mesh import Caster, Surface, caster_of, first_hits, triangle_normals

from ._camera import Camera, pixel_centres, rays


@final
class PixelMap(eqx.Module):
    """What each pixel sees; all leaves are NumPy arrays. Make one with `look`.

    It is made once for a camera and a surface; pictures are then a weighing of three vertices each.

    Arguments:

    - `triangle`: seen, (rows, columns); -1 where nothing is.
    - `depth`: along the camera's axis, (rows, columns) [m]; NaN where nothing is seen.
    - `cosine`: between outward normal and line of sight, (rows, columns) [1]: 1 where the camera
      looks at a face from straight before it, NaN where nothing is seen.
    - `hit`: the pixels that see something, numbered row after row, (hits,), increasing.
    - `corners`: vertex numbers of what they see, (hits, 3).
    - `weights`: barycentric, (hits, 3) [1]: at least 0, of sum 1.
    - `vertices`: how many the surface has.
    """

    triangle: Int[np.ndarray, "rows columns"]
    depth: Float[np.ndarray, "rows columns"]
    cosine: Float[np.ndarray, "rows columns"]
    hit: Int[np.ndarray, " hits"]
    corners: Int[np.ndarray, "hits 3"]
    weights: Float[np.ndarray, "hits 3"]
    vertices: int = eqx.field(static=True)

    def size(self) -> tuple[int, int]:
        """Rows and columns of a frame [px]."""
        return self.triangle.shape[0], self.triangle.shape[1]


def look(camera: Camera, surface: Surface) -> PixelMap:
    """What each pixel's centre sees of a surface [m], through the lens, by casting rays.

    With lambda_r >= 0 and lambda_1 + lambda_2 + lambda_3 = 1 the line of sight meets the triangle
    at lambda_1 v_1 + lambda_2 v_2 + lambda_3 v_3. Triangles are seen from both sides.

    Raises `InputError` for a surface without triangles or with vertices that are not finite.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F7, F9).
    """
    return look_by(caster_of(surface), camera, surface)


def look_by(caster: Caster, camera: Camera, surface: Surface) -> PixelMap:
    """`look` with the surface's [m] own caster, which is made once for all cameras."""
    shape = (camera.height, camera.width)
    lines = rays(camera, pixel_centres(camera))
    hits = first_hits(caster, camera.place(), lines)
    hit = np.flatnonzero(hits.triangle >= 0)
    seen = hits.triangle[hit]
    depth, cosine = np.full(len(lines), np.nan), np.full(len(lines), np.nan)
    depth[hit] = hits.distance[hit] * (lines[hit] @ camera.pose[2, :3])
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    cosine[hit] = -np.einsum("ij,ij->i", normals[seen], lines[hit])
    return PixelMap(
        hits.triangle.reshape(shape).astype(np.int32), depth.reshape(shape), cosine.reshape(shape),
        hit, surface.triangles[seen].astype(np.int64), hits.weights[hit], len(surface.vertices),
    )  # fmt: skip


def depth_at(
    pixel_map: PixelMap, pixels: Float[np.ndarray, "points 2"]
) -> Float[np.ndarray, " points"]:
    """The depth [m] that the pixel nearest to each place [px] sees: D(u, v) of the paper.

    NaN outside of the frame, for places that are NaN, and where the pixel sees nothing.
    """
    rows, columns = pixel_map.size()
    with np.errstate(invalid="ignore"):
        nearest = np.floor(pixels + 0.5)
        inside = np.all((nearest >= 0) & (nearest < [columns, rows]), axis=1)
    column, row = np.where(inside[:, None], nearest, 0.0).astype(int).T
    return np.where(inside, pixel_map.depth[row, column], np.nan)

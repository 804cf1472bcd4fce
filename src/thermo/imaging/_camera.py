"""A pinhole camera with a lens, where it stands and how it projects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.observe import check_number, real_array

from ._distortion import distorted, undistorted
from ._pose import checked_pose, inverse_of


@final
class Camera(eqx.Module):
    """A calibrated camera; all leaves are NumPy arrays.

    The centre of the first pixel, at the upper left, is at (0, 0); the first coordinate counts
    columns and the second rows. The camera's axes are OpenCV's: x right, y down, z forward.

    Arguments:

    - `width`, `height`: of its frames [px].
    - `focal`: f_x and f_y [px]. `centre`: c_x and c_y of the principal point [px].
    - `pose`: world to camera, (4, 4), its last column in metres.
    - `distortion`: k1, k2, p1, p2, k3 of Brown and Conrady [1].
    - `name`: what messages and files call it. `where`: the file that it was read from.

    Raises `InputError` for sizes and focal lengths that are not positive and for poses that do more
    than turn and shift.

    Source: paper, appendix A.1 (checklist F6).
    """

    width: int = eqx.field(static=True)
    height: int = eqx.field(static=True)
    focal: Float[np.ndarray, "2"]
    centre: Float[np.ndarray, "2"]
    pose: Float[np.ndarray, "4 4"]
    distortion: Float[np.ndarray, "5"]
    name: str = eqx.field(static=True)

    def __init__(
        self,
        width: int,
        height: int,
        focal: Sequence[float] | Float[np.ndarray, "2"],
        centre: Sequence[float] | Float[np.ndarray, "2"],
        pose: Float[np.ndarray, "_ 4"],
        distortion: Sequence[float] | Float[np.ndarray, "5"] = (0.0, 0.0, 0.0, 0.0, 0.0),
        *,
        name: str = "camera",
        where: str = "camera",
    ) -> None:
        for key, value in (("width", width), ("height", height)):
            if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
                raise InputError(
                    "a frame has no such size", where=f"{where}: {key}", value=value,
                    limit="a whole number of pixels above 0", remedy="give the size of the frames",
                )  # fmt: skip
        self.width, self.height, self.name = int(width), int(height), name
        self.focal = _numbers(focal, 2, f"{where}: focal", "focal lengths [px]")
        for value in self.focal:
            check_number(value, where=f"{where}: focal", quantity="focal length [px]", above=0.0)
        self.centre = _numbers(centre, 2, f"{where}: centre", "principal point [px]")
        self.distortion = _numbers(distortion, 5, f"{where}: distortion", "k1, k2, p1, p2, k3")
        self.pose = checked_pose(pose, where=f"{where}: pose")

    def place(self) -> Float[np.ndarray, "3"]:
        """Where the camera stands in the world [m]."""
        return inverse_of(self.pose)[:3, 3]


def project(
    camera: Camera, points: Float[np.ndarray, "points 3"]
) -> tuple[Float[np.ndarray, "points 2"], Float[np.ndarray, " points"]]:
    """Where points of the world [m] are seen [px], and how deep they lie along the axis [m].

    u = f_x x'/z + c_x and v = f_y y'/z + c_y, after the lens. Points at or behind the camera are
    seen nowhere, NaN.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F6).
    """
    seen = points @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    depth = seen[:, 2]
    with np.errstate(all="ignore"):
        flat = np.where((depth > 0)[:, None], seen[:, :2] / depth[:, None], np.nan)
    return distorted(flat, camera.distortion) * camera.focal + camera.centre, depth


def rays(camera: Camera, pixels: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "points 3"]:
    """Lines of sight of pixels [px] in the world, of length one [1]; NaN where there is none.

    They begin at `camera.place()`.
    """
    flat = undistorted((pixels - camera.centre) / camera.focal, camera.distortion)
    seen = np.concatenate([flat, np.ones((len(flat), 1))], axis=1)
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    return seen @ camera.pose[:3, :3]


def pixel_centres(camera: Camera) -> Float[np.ndarray, "pixels 2"]:
    """Columns and rows [px] of all pixels, row after row."""
    rows, columns = np.mgrid[: camera.height, : camera.width]
    return np.stack([columns.ravel(), rows.ravel()], axis=1).astype(float)


def _numbers(value: object, count: int, where: str, quantity: str) -> np.ndarray:
    values = real_array(value, where=where, quantity=quantity)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise InputError(
            f"{quantity} do not fit", where=where, value=values.tolist(),
            limit=f"{count} finite numbers", remedy="look into the camera's calibration",
        )  # fmt: skip
    return values

"""A picture of the object, and where the object is in it."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.imaging import Camera


@final
class Photograph(eqx.Module):
    """What a calibrated camera saw of the object.

    Arguments:

    - `camera`: that took it.
    - `colour`: red, green and blue as stored, (rows, columns, 3), 0 to 1 [1].
    - `mask`: share of each pixel that the object covers, (rows, columns), 0 to 1 [1]; None where
      nobody knows.
    - `file`: what messages call it.

    Raises `InputError` for pictures and masks of another size than the camera's.
    """

    camera: Camera
    colour: Float[np.ndarray, "rows columns 3"]
    mask: Float[np.ndarray, "rows columns"] | None
    file: str = eqx.field(static=True)

    def __check_init__(self) -> None:
        stated = (self.camera.height, self.camera.width)
        for what, values in (("picture", self.colour), ("mask", self.mask)):
            if values is not None and values.shape[:2] != stated:
                raise InputError(
                    f"this {what} has another size than its camera", where=self.file,
                    value=f"{values.shape[1]} x {values.shape[0]} pixels",
                    limit=f"{stated[1]} x {stated[0]} pixels",
                    remedy="give pictures as they were calibrated, neither cropped nor scaled",
                )  # fmt: skip

"""A camera beside the file that it recorded."""

from __future__ import annotations

from typing import final

import equinox as eqx

from ._camera import Camera


@final
class View(eqx.Module):
    """A calibrated camera, and what it recorded.

    Arguments:

    - `camera`: where it stands and how it projects.
    - `file`: its picture or recording as the calibration names it, relative to the calibration; an
      empty text where it names none.
    - `time`: when that one picture was taken [s], for a camera that moves; None where `file` is a
      recording of a camera that stands still.
    """

    camera: Camera
    file: str = eqx.field(static=True)
    time: float | None = eqx.field(static=True, default=None)

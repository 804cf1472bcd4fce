"""Whether the samples of a recording lie on the surface that they are bound to."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

_MEDIAN_SHARE: Final = 0.02
_LARGEST_SHARE: Final = 0.10


def check_distance(distance: Float[np.ndarray, " samples"], *, diagonal: float, where: str) -> None:
    """Refuse samples that lie away from the surface.

    Arguments:

    - `distance`: from each sample to its nearest surface point, (samples,) [m].
    - `diagonal`: diagonal of the object's bounding box [m].
    - `where`: what messages call the recording.

    Raises `InputError` if the median is above 2 % of the diagonal, if any distance is above
    10 %, or if one is not finite.
    """
    values = np.asarray(distance, dtype=np.float64)
    median, largest = float(np.median(values)), float(np.max(values))
    # Written so that NaN is refused too.
    if median <= _MEDIAN_SHARE * diagonal and largest <= _LARGEST_SHARE * diagonal:
        return
    raise InputError(
        "samples lie away from the surface", where=f"{where}: points",
        value=f"median distance {median:.3g} m, largest {largest:.3g} m "
        f"(sample {int(np.argmax(values))}); the object's diagonal is {diagonal:.3g} m",
        limit=f"median at most {_MEDIAN_SHARE:.0%} and every one at most {_LARGEST_SHARE:.0%} "
        f"of the diagonal ({_MEDIAN_SHARE * diagonal:.3g} m, {_LARGEST_SHARE * diagonal:.3g} m)",
        remedy=_remedy(median, diagonal),
    )  # fmt: skip


def _remedy(median: float, diagonal: float) -> str:
    if median > 100 * diagonal:
        return (
            "the points look like millimetres: give them in metres, or name the columns of a CSV "
            "file, that of the sensors too, x_mm, y_mm, z_mm; or check the surface's unit"
        )
    if median <= _MEDIAN_SHARE * diagonal:
        return (
            "drop the stray samples from the recording (its first sample is number 0); reflections "
            "often cause them"
        )
    return "check that points and surface share one frame (registration) and are both in metres"

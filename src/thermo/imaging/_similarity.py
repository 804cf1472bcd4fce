"""Similarity transformations: a turn, a shift and a scale."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from thermo.errors import InputError
from thermo.observe import check_number

from ._pose import checked_pose


@final
class Similarity(eqx.Module):
    """x' = s R x + t; all leaves are NumPy arrays or floats.

    Arguments:

    - `rotation`: R, (3, 3) [1]; one where it is left out.
    - `shift`: t, (3,) [m]; none where it is left out.
    - `scale`: s [1].
    - `where`: what messages call it.

    Raises `InputError` for a rotation that does more than turn, for numbers that are not finite,
    and for a scale that is not positive.
    """

    rotation: Float[np.ndarray, "3 3"]
    shift: Float[np.ndarray, "3"]
    scale: float

    def __init__(
        self,
        rotation: ArrayLike | None = None,
        shift: ArrayLike | None = None,
        scale: float = 1.0,
        *,
        where: str = "similarity",
    ) -> None:
        turn = np.eye(3) if rotation is None else np.asarray(rotation)
        moved = np.zeros(3) if shift is None else np.asarray(shift)
        if turn.shape != (3, 3) or moved.shape != (3,):
            raise InputError(
                "this is no similarity", where=where,
                value=f"rotation of shape {turn.shape}, shift of shape {moved.shape}",
                limit="a rotation (3, 3) and a shift (3,) in metres",
                remedy="give the shift and the scale apart from the rotation",
            )  # fmt: skip
        pose = checked_pose(np.concatenate([turn, moved[:, None]], axis=1), where=where)
        self.rotation, self.shift = pose[:3, :3], pose[:3, 3]
        self.scale = check_number(scale, where=f"{where}: scale", quantity="scale [1]", above=0.0)

    def apply(self, points: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Where points [m] are brought to [m]."""
        return self.scale * points @ self.rotation.T + self.shift

    def after(self, first: Similarity) -> Similarity:
        """Both in one: `first`, then this."""
        return Similarity(
            self.rotation @ first.rotation,
            self.scale * self.rotation @ first.shift + self.shift,
            self.scale * first.scale,
        )

    def inverse(self) -> Similarity:
        """What brings points back: x = R^T (x' - t) / s."""
        back = self.rotation.T
        return Similarity(back, -back @ self.shift / self.scale, 1.0 / self.scale)


def similarity_about(centre: Float[np.ndarray, "3"], motion: Float[np.ndarray, "7"]) -> Similarity:
    """The similarity x' = c + t + exp(a) R(w) (x - c) about a centre c [m].

    Arguments: `motion`, the rotation vector w [rad], the shift of the centre t [m] and the
    logarithm of the scale a [1], one after the other.
    """
    turn = Rotation.from_rotvec(motion[:3]).as_matrix()
    scale = float(np.exp(motion[6]))
    return Similarity(turn, centre + motion[3:6] - scale * turn @ centre, scale)


def motion_about(centre: Float[np.ndarray, "3"], similarity: Similarity) -> Float[np.ndarray, "7"]:
    """The inverse of `similarity_about`: rotation vector [rad], shift [m], logarithm of scale [1].

    The rotation vector is the shortest, of at most pi.
    """
    turn = Rotation.from_matrix(similarity.rotation).as_rotvec()
    shift = similarity.apply(centre[None])[0] - centre
    return np.concatenate([turn, shift, [np.log(similarity.scale)]])

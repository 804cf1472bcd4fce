"""Damped, robust Gauss-Newton steps over the pose and the scale of an object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from ._similarity import Similarity, similarity_about

_CUT: Final = 4.685
"""Deviations beyond which a residual counts nothing [1]: Tukey's, 95 % efficient if normal."""

_STEPS: Final = 80
"""Steps at the most, tried ones included [1]."""

_DAMPING: Final = (1e-4, 1.0)
"""Least and greatest damping, over the mean square sensitivity of the residuals [1]."""

_CALM: Final = (15, 1.5)
"""Step from which the least damping grows, and by what each: where residuals tell little of a
motion, matching anew would move the object about for ever [1]."""

_WORSE: Final = 1.02
"""What a step may raise the loss by [1]: matching anew makes it rough near the least."""


@final
class Matched(eqx.Module):
    """What one pose leaves: residuals and how they change as the matched points move.

    Arguments:

    - `residual`: (residuals,) in their own unit [px] or [m].
    - `points`: (residuals, 3) of the surface, in the world [m].
    - `slope`: (residuals, 3) of each residual by its point [px/m] or [1].
    - `floor`: what the residuals' deviation is at least, in their unit.
    """

    residual: Float[np.ndarray, " residuals"]
    points: Float[np.ndarray, "residuals 3"]
    slope: Float[np.ndarray, "residuals 3"]
    floor: float

    def spread(self) -> float:
        """Deviation of the residuals, from the median of their size, at least the floor."""
        return max(1.4826 * float(np.median(np.abs(self.residual))), self.floor)

    def weights(self) -> Float[np.ndarray, " residuals"]:
        """Tukey's weights [1]."""
        ratio = self.residual / (_CUT * self.spread())
        return np.maximum(1.0 - ratio**2, 0.0) ** 2

    def cost(self, spread: float) -> float:
        """Mean of Tukey's loss [1], which is 1 far out."""
        inside = np.maximum(1.0 - (self.residual / (_CUT * spread)) ** 2, 0.0)
        return float(1.0 - (inside**3).mean())

    def jacobian(
        self, centre: Float[np.ndarray, "3"], size: float, free: int
    ) -> Float[np.ndarray, "residuals free"]:
        """Slopes by the motion of the surface [m]: `size` w, t and `size` a of `similarity_about`.

        Arguments: `centre` [m] and `size` [m] of the object; `free`, 6 or 7 with the scale.
        """
        arm = self.points - centre
        turn, grow = np.cross(arm, self.slope), np.einsum("ij,ij->i", arm, self.slope)
        columns = [turn / size, self.slope, grow[:, None] / size]
        return np.concatenate(columns, axis=1)[:, :free]


@final
class Descent(eqx.Module):
    """Where `descend` ended.

    Arguments: `similarity`; `matched` there; `steps` taken; `converged`, whether the last step
    changed the residuals by less than asked for.
    """

    similarity: Similarity
    matched: Matched
    steps: int
    converged: bool


def descend(
    match: Callable[[Similarity], Matched],
    start: Similarity,
    centre: Float[np.ndarray, "3"],
    size: float,
    *,
    scale: bool,
    enough: float,
) -> Descent:
    """Move an object until its residuals are least, matching anew after each step.

    Each step solves (J^T W J + m n f^2) d = -J^T W r with Tukey's weights W, the number n and the
    mean square slope f^2 of the residuals. The damping m stays above 1e-4, and
    grows after fifteen steps, so that the object does not drift where residuals do not change.

    Arguments:

    - `match`: residuals at a pose.
    - `start`: the first pose.
    - `centre`: of the object in its own axes [m]; `size`: root mean square distance from it [m].
    - `scale`: whether the scale is free too.
    - `enough`: a root mean square change of the residuals that ends the descent, in their unit.

    Source: Levenberg, Quarterly of Applied Mathematics 2 (1944) 164; weights of Beaton and Tukey,
    Technometrics 16 (1974) 147.
    """
    now, free, damping = start, 6 + scale, 1e-2
    matched, converged, steps = match(now), False, 0
    for steps in range(1, _STEPS + 1):  # noqa: B007
        there, length = now.apply(centre[None])[0], size * now.scale
        jacobian = matched.jacobian(there, length, free)
        weighted = jacobian * matched.weights()[:, None]
        hessian = weighted.T @ jacobian
        power = (matched.slope**2).sum() * matched.weights().mean()
        step = np.linalg.solve(
            hessian + damping * power * np.eye(free), -weighted.T @ matched.residual
        )
        tried = moved(now, centre, size, step)
        change = float(np.sqrt(np.mean((jacobian @ step) ** 2)))
        new, spread = match(tried), matched.spread()
        if new.cost(spread) <= _WORSE * matched.cost(spread):
            least = _DAMPING[0] * _CALM[1] ** max(0, steps - _CALM[0])
            now, matched, damping = tried, new, max(damping / 5, least)
            converged = change < enough
        elif damping < _DAMPING[1]:
            damping *= 10
        else:
            # Shorter steps do not help either: what is left comes from matching anew.
            converged = change < 10 * enough
            break
        if converged:
            break
    return Descent(now, matched, steps, converged)


def moved(
    now: Similarity,
    centre: Float[np.ndarray, "3"],
    size: float,
    step: Float[np.ndarray, " free"],
) -> Similarity:
    """A pose after a step, given as motion of the surface [m] in the order of `jacobian`.

    Arguments: `centre` [m] and `size` [m] of the object in its own axes.
    """
    there, length = now.apply(centre[None])[0], size * now.scale
    motion = np.zeros(7)
    motion[: len(step)] = step
    motion[:3] /= length
    motion[6] /= length
    return similarity_about(there, motion).after(now)

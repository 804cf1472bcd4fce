"""Which motions of an object its residuals do not tell, and how well they tell the others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from ._align_descend import Descent, Matched, moved
from ._similarity import Similarity

_REACH: Final = 0.1
"""How far the surface is moved to see whether residuals change, over the object's size [1]."""

_CLEAR: Final = 0.3
"""Motions told by at least this part of the greatest possible slope need no trial [1]."""

_RISE: Final = 1.25
"""Least rise of the mean square that tells a motion [1]."""

_PART: Final = 0.1
"""Parts of a motion below this are left out of it where it stays untold without them [1]."""

_STEP: Final = 0.25
"""Root mean square change of the residuals by which their slope is measured, over their deviation:
little beside the 4.7 of them over which Tukey's weights fall to nothing [1]."""


@final
class Knowledge(eqx.Module):
    """What the residuals tell of the object's pose.

    Arguments:

    - `deviation`: of the rotation vector [rad], the shift [m] and the logarithm of the scale [1].
    - `untold`: the motions that are not told, in words.
    """

    deviation: Float[np.ndarray, "7"]
    untold: tuple[str, ...] = eqx.field(static=True)


def knowledge(
    match: Callable[[Similarity], Matched],
    found: Descent,
    centre: Float[np.ndarray, "3"],
    size: float,
    *,
    scale: bool,
    inflation: float,
    apart: float | None = None,
) -> Knowledge:
    """Deviations of the pose, and the motions that are not told.

    The Hessian J^T W J is taken by the motion of the surface [m], so that its eigenvalues compare.
    Along each eigenvector of small slope the object is moved both ways by a tenth of its size:
    where the mean square of the residuals does not rise by a quarter, nor by more than four
    deviations of its own, 4 sqrt(2 c / n), the motion is not told. Such a motion counts with the
    object's whole size in the deviations; others with the residuals' variance over the
    eigenvalue.

    Arguments:

    - `match`, `found`: of the descent.
    - `centre`: of the object in its own axes [m]; `size`: root mean square distance from it [m].
    - `scale`: whether the scale was free.
    - `inflation`: c, how many residuals tell as much as one independent one [1].
    - `apart`: mean distance of the cameras [m], where there are cameras.
    """
    there, length = found.similarity.apply(centre[None])[0], size * found.similarity.scale
    matched, free = found.matched, 6 + scale
    jacobian, weights = matched.jacobian(there, length, free), matched.weights()
    values, vectors = np.linalg.eigh((jacobian * weights[:, None]).T @ jacobian)
    noise = inflation * ((weights * matched.residual) ** 2).sum() / max(weights.sum() - free, 1.0)
    greatest = float((weights[:, None] * matched.slope**2).sum())
    # The size of an object of which the root mean square is known: that of a ball's surface.
    whole = 2 * length
    variance, untold = np.zeros(free), []
    limit = max(_RISE, 1 + 4 * math.sqrt(2 * inflation / len(weights)))

    def hidden(vector: Float[np.ndarray, " free"]) -> bool:
        return _rise(match, found, centre, size, _REACH * whole * vector) <= limit

    told = [k for k in range(free) if values[k] > _CLEAR**2 * greatest or not hidden(vectors[:, k])]
    gain = _gain(match, found, centre, size, vectors[:, told] / np.sqrt(values[told]))
    for k in range(free):
        vector = vectors[:, k]
        if k in told:
            variance += vector**2 * min(noise / max(values[k] * gain**2, 1e-300), whole**2)
            continue
        # Noise in the slopes mixes a little of the other motions into one that is not told.
        plain = np.where(np.abs(vector) < _PART, 0.0, vector)
        plain /= np.linalg.norm(plain)
        vector = plain if hidden(plain) else vector
        variance += vector**2 * whole**2
        untold.append(in_words(vector, length, apart))
    deviation = np.zeros(7)
    deviation[:free] = np.sqrt(variance)
    deviation[[0, 1, 2, 6]] /= length
    return Knowledge(deviation, tuple(untold))


def inflation(
    groups: Iterable[tuple[Float[np.ndarray, "residuals axes"], Float[np.ndarray, " residuals"]]],
    reach: float,
    free: int,
) -> float:
    """How many residuals tell as much as one independent one [1].

    c = (1 + 2 sum r_i r_j / sum r_i^2) / (1 - 2 p f / n^2): the products of weighted residuals over
    all p pairs near each other, and what the f free numbers took of the sums over each one's
    neighbours, 2 p / n.

    Arguments: the places of residuals that may be alike, in any unit, and the weighted residuals
    there; `reach`, how near to each other, in that unit; `free` numbers of the fit.

    Source: Conley, Journal of Econometrics 92 (1999) 1.
    """
    products, squares, pairs, count = 0.0, 0.0, 0, 0
    for places, weighted in groups:
        near = KDTree(places).query_pairs(reach, output_type="ndarray")
        products += float((weighted[near[:, 0]] * weighted[near[:, 1]]).sum())
        squares += float((weighted**2).sum())
        pairs += len(near)
        count += len(weighted)
    alike = 1.0 + 2.0 * products / max(squares, 1e-300)
    return max(1.0, alike) / max(1.0 - 2 * pairs * free / count**2, 0.1)


def _gain(
    match: Callable[[Similarity], Matched],
    found: Descent,
    centre: Float[np.ndarray, "3"],
    size: float,
    told: Float[np.ndarray, "free told"],
) -> float:
    """How fast J^T W r changes along all told motions, over J^T W J [1]: at the least a tenth.

    Arguments: `told`, the motions, each of as long a step as changes J^T W J by one.
    """
    motion, count = told.sum(axis=1), max(told.shape[1], 1)
    before = found.matched
    step = _STEP * before.spread() * math.sqrt(before.weights().sum() / count)
    change = 0.0
    for sign in (1.0, -1.0):
        pose = moved(found.similarity, centre, size, sign * step * motion)
        now = match(pose)
        there, length = pose.apply(centre[None])[0], size * pose.scale
        slope = now.jacobian(there, length, len(motion)) @ motion
        change += sign * float(slope @ (now.weights() * now.residual))
    return max(change / (2 * step * count), 0.1)


def _rise(
    match: Callable[[Similarity], Matched],
    found: Descent,
    centre: Float[np.ndarray, "3"],
    size: float,
    step: Float[np.ndarray, " free"],
) -> float:
    """Mean square of the residuals after a step [m] either way over that before [1].

    Of the residuals, the smallest, as many as lay within three deviations before.
    """
    part = float(np.mean(np.abs(found.matched.residual) < 3 * found.matched.spread()))

    def power(matched: Matched) -> float:
        kept = np.sort(np.abs(matched.residual))[: max(1, int(part * len(matched.residual)))]
        return float(np.mean(kept**2))

    ways = [match(moved(found.similarity, centre, size, sign * step)) for sign in (1.0, -1.0)]
    least = (0.1 * found.matched.floor) ** 2
    return sum(power(way) for way in ways) / 2 / max(power(found.matched), least)


def in_words(vector: Float[np.ndarray, " free"], length: float, apart: float | None = None) -> str:
    """Name a motion of the surface [m]: the turn times `length`, the shift, the growth times it.

    Arguments: `vector` of length one; `length`: root mean square distance from the centre [m];
    `apart`: mean distance of the cameras [m]: a growth with a shift that makes up for it is one.
    """
    turn, shift = vector[:3], vector[3:6]
    grow = abs(float(vector[6])) if len(vector) > 6 else 0.0
    sizes = np.array([np.linalg.norm(turn), np.linalg.norm(shift), grow])
    if apart is not None and grow * apart > 0.5 * length * sizes[1] > 0.25 * length * sizes[0]:
        if sizes[1] > 0.5 * grow:
            return "scale and distance together"
    most = int(np.argmax(sizes))
    if most == 2:
        return "scale"
    return f"rotation about {_axis(turn)}" if most == 0 else f"shift along {_axis(shift)}"


def _axis(vector: Float[np.ndarray, "3"]) -> str:
    unit = vector / np.linalg.norm(vector)
    unit = unit * np.sign(unit[np.argmax(np.abs(unit))])
    shown = [f"{value:.2f}".rstrip("0").rstrip(".") for value in np.round(unit, 2) + 0.0]
    return f"[{', '.join(shown)}]"

"""What a fit of fields makes small, as a function of their departure from an estimate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._objective import Objective, residual, start


@final
@dataclass(frozen=True)
class FieldLoss:
    """chi^2(d): whitened residuals of runs and priors, squared and summed, at departures d.

    - `of`: at departures (unknowns,) [1], the controls of all fields in the order of their names,
      the sum [1] and the slope of half of it (unknowns,) [1].
    - `first`: the most probable departures as far as slopes tell, (unknowns,) [1].
    - `curvature`: of half the sum near there, (unknowns, unknowns) [1].
    """

    of: Callable[[Float[np.ndarray, " unknowns"]], tuple[float, Float[np.ndarray, " unknowns"]]]
    first: Float[np.ndarray, " unknowns"]
    curvature: Float[np.ndarray, "unknowns unknowns"]


def field_loss(
    objective: Objective,
    first: Float[np.ndarray, " unknowns"],
    curvature: Float[np.ndarray, "unknowns unknowns"],
) -> FieldLoss:
    """The loss of departing fields, whose smoothness and weights of runs [1] are chosen."""

    def of(
        departures: Float[np.ndarray, " unknowns"],
    ) -> tuple[float, Float[np.ndarray, " unknowns"]]:
        half, slope = _half(objective, jnp.asarray(departures, float))
        return 2 * float(half), np.asarray(slope)

    return FieldLoss(of, first, curvature)


@program
def _half(
    objective: Objective, departures: Float[Array, " unknowns"]
) -> tuple[Float[Array, ""], Float[Array, " unknowns"]]:
    """Half the sum of squares and its slope, by one reverse pass."""
    _, unravel = ravel_pytree(start(objective))

    def half(point: Float[Array, " unknowns"]) -> Float[Array, ""]:
        return 0.5 * jnp.sum(residual(objective, unravel(point)) ** 2)

    return jax.value_and_grad(half)(departures)

"""How a surface is trained."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

from ._objective import Balance
from ._render_rays import Sampling


@final
class Training(eqx.Module):
    """Sizes and rates of a training.

    - `steps`: how many. `rays`: of each step.
    - `cells`: an edge of each grid of the encoding, coarse to fine. `features`: at each corner.
      `width`: of hidden layers. `told`: numbers that the colour is told of a place.
    - `rate`: of learning, at its highest; it rises over `warm` steps and falls along a cosine to a
      twentieth.
    - `opened`: share of the steps after which all grids take part.
    - `sampling`, `balance`: of rays and of the objective. `seed`: of all that is drawn.

    Numbers are counts or shares [1].
    """

    steps: int = eqx.field(static=True, default=4000)
    rays: int = eqx.field(static=True, default=512)
    cells: tuple[int, ...] = eqx.field(static=True, default=(16, 32, 64))
    features: int = eqx.field(static=True, default=2)
    width: int = eqx.field(static=True, default=64)
    told: int = eqx.field(static=True, default=15)
    rate: float = eqx.field(static=True, default=5e-3)
    warm: int = eqx.field(static=True, default=100)
    opened: float = eqx.field(static=True, default=0.5)
    sampling: Sampling = Sampling()
    balance: Balance = Balance()
    seed: int = eqx.field(static=True, default=0)


def optimiser(training: Training) -> optax.GradientTransformation:
    """Adam; steps of one size whatever the gradient's, since most corners are seldom met.

    Source: Mueller et al., ACM Transactions on Graphics 41 (2022) 102, section 4 (its moments).
    """
    rate = optax.warmup_cosine_decay_schedule(
        0.0, training.rate, min(training.warm, training.steps // 2), training.steps,
        0.05 * training.rate,
    )  # fmt: skip
    return optax.adam(rate, b1=0.9, b2=0.99, eps=1e-15)


def open_levels(training: Training, step: Int[Array, ""]) -> Float[Array, ""]:
    """Levels of the encoding that take part at a step [1]: one at first, then one after another."""
    share = step / max(training.opened * training.steps, 1.0)
    levels = len(training.cells)
    return jnp.minimum(1.0 + (levels - 1) * share, levels).astype(jnp.float32)

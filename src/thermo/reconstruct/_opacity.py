"""How much of a ray ends in each of its sections, from the distance."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


def section_opacity(
    before: Float[Array, "*rays sections"],
    after: Float[Array, "*rays sections"],
    sharpness: Float[Array, ""],
) -> Float[Array, "*rays sections"]:
    """alpha = max((Phi(f_0) - Phi(f_1)) / Phi(f_0), 0) of sections of rays [1].

    Phi is the logistic function of slope s. Where a ray leaves the body nothing is added.

    Arguments: distance `before` and `after` each section [half an edge], `sharpness` s [1 / half an
    edge].

    Source: paper, appendix B.1 (checklist A3); Wang et al., NeurIPS 2021 (NeuS), equation 13.
    """
    # 1 - Phi(f_1) / Phi(f_0) by logarithms: deep inside both are too small for single precision.
    ratio = jax.nn.log_sigmoid(sharpness * after) - jax.nn.log_sigmoid(sharpness * before)
    return -jnp.expm1(jnp.minimum(ratio, 0.0))


def weights(opacity: Float[Array, "*rays sections"]) -> Float[Array, "*rays sections"]:
    """w_i = alpha_i prod_{j < i} (1 - alpha_j) [1]; they add up to one at the most.

    Source: paper, appendix B.1 (checklist A4).
    """
    left = jnp.cumprod(1.0 - opacity, axis=-1)
    through = jnp.concatenate([jnp.ones_like(left[..., :1]), left[..., :-1]], axis=-1)
    return opacity * through

"""Products of nodal values, node by node, that keep a batch beside the nodes.

A plain product of one vector with a batch of them moves the batch to the front under `jax.vmap`,
and what follows then gathers from far.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float


def _scaled(factor: Array, vector: Array) -> Array:
    batch = max(factor.ndim, vector.ndim)
    return jnp.expand_dims(factor, range(factor.ndim, batch)) * jnp.expand_dims(
        vector, range(vector.ndim, batch)
    )


_scale_p: Any = Primitive("diagonal_product")
_scale_p.def_impl(jax.jit(_scaled))


@_scale_p.def_abstract_eval
def _scaled_shape(factor: Any, vector: Any) -> Any:
    wide = factor if len(factor.shape) > len(vector.shape) else vector
    return ShapedArray(wide.shape, jnp.result_type(factor, vector))


def _scale_transpose(given: Any, factor: Any, vector: Any) -> Any:
    known, asked = (vector, factor) if ad.is_undefined_primal(factor) else (factor, vector)
    back = _scale_p.bind(known, given)
    # What served a whole batch answers for all of it.
    back = back if asked.aval.ndim == back.ndim else back.sum(range(asked.aval.ndim, back.ndim))
    return (back, None) if ad.is_undefined_primal(factor) else (None, back)


def _scale_batch(arguments: Any, axes: Any) -> Any:
    moved = [
        a if x is None else jnp.moveaxis(a, x, -1) for a, x in zip(arguments, axes, strict=True)
    ]
    depth = max(a.ndim - (x is not None) for a, x in zip(moved, axes, strict=True))
    # A batch of batches: the new axis is last, whatever the others have.
    full = []
    for a, axis in zip(moved, axes, strict=True):
        missing = 0 if axis is None else depth + 1 - a.ndim
        full.append(jnp.expand_dims(a, range(a.ndim - 1, a.ndim - 1 + missing)))
    return _scale_p.bind(*full), depth


ad.defjvp(
    _scale_p,
    lambda change, factor, vector: _scale_p.bind(change, vector),
    lambda change, factor, vector: _scale_p.bind(factor, change),
)
ad.primitive_transposes[_scale_p] = _scale_transpose
batching.primitive_batchers[_scale_p] = _scale_batch
mlir.register_lowering(_scale_p, mlir.lower_fun(_scaled, multiple_results=False))


def diagonal_product(
    diagonal: Float[Array, " nodes"], vector: Float[Array, " nodes"]
) -> Float[Array, " nodes"]:
    """Diagonal matrix times vector: in [W] for W/K times K, for example."""
    return _scale_p.bind(diagonal, vector)

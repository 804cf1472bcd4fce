"""Products with a symmetric matrix given by its edges, as one primitive of the compiler's.

Written with gathers and scatters such a product is slow: the scatter runs entry by entry, and a
batch of tangents is laid out with each direction apart. As a primitive it is linear in the edges
and in the vector, its own transpose in the vector, and a batch of either is laid out with the
directions of a node side by side, so that one gather serves them all. A batch of edges, such as
their tangents, is read from memory in each step, and takes half as long in single precision.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float

from thermo.physics._diagonal_product import diagonal_product
from thermo.physics._gather_sum import pick
from thermo.physics._pattern import Pattern, Rows, row_product


def _rows(
    edges: Array, vector: Array, *leaves: Any, shape: Any, differences: bool, single: bool
) -> Float[Array, "nodes *batch"]:
    """Sum over the neighbours of each node, from the padded rows where they are at hand."""
    pattern, rows = jax.tree.unflatten(shape, leaves)
    if rows is not None:
        return row_product(pattern, None, rows, vector, differences=differences)
    batch = max(edges.ndim, vector.ndim) - 1
    edges = edges.reshape(*edges.shape, *(1,) * (batch + 1 - edges.ndim))
    vector = vector.reshape(*vector.shape, *(1,) * (batch + 1 - vector.ndim))
    if single and edges.shape[-1] > 1:
        edges = edges.astype(jnp.float32)
    # Padded entries point past the last edge, at zero.
    edges = jnp.concatenate([edges, jnp.zeros((1, *edges.shape[1:]), edges.dtype)])
    return row_product(pattern, None, pattern.source, vector, differences=differences, lookup=edges)


_product_p: Any = Primitive("edge_product")
_product_p.def_impl(jax.jit(_rows, static_argnames=("shape", "differences", "single")))


@_product_p.def_abstract_eval
def _abstract(edges: Any, vector: Any, *leaves: Any, shape: Any, **how: bool) -> Any:
    del leaves, shape, how
    batch = edges.shape[1:] or vector.shape[1:]
    return ShapedArray((vector.shape[0], *batch), jnp.result_type(edges, vector))


def _zero(value: Array) -> Any:
    zero: Any = ad.Zero
    return zero.from_primal_value(value)


def _bind(edges: Array, vector: Array, parts: Any, **how: bool) -> Array:
    leaves, shape = jax.tree.flatten(parts)
    return _product_p.bind(edges, vector, *leaves, shape=shape, **how)


def _jvp(primals: Any, tangents: Any, *, shape: Any, **how: bool) -> Any:
    edges, vector, *leaves = primals
    parts = jax.tree.unflatten(shape, leaves)
    terms = []
    if not isinstance(tangents[0], ad.Zero):
        # The padded rows are those of the edges, not of their tangent.
        terms.append(_bind(tangents[0], vector, (parts[0], None), **how))
    if not isinstance(tangents[1], ad.Zero):
        terms.append(_bind(edges, tangents[1], parts, **how))
    out = _bind(edges, vector, parts, **how)
    return out, sum(terms) if terms else _zero(out)


def _transpose(given: Any, edges: Any, vector: Any, *leaves: Any, shape: Any, **how: bool) -> Any:
    nothing = [None] * len(leaves)
    parts = jax.tree.unflatten(shape, leaves)
    if ad.is_undefined_primal(vector):
        back = _bind(edges, given, parts, **how)
        # A vector that served a whole batch of edges answers for all of it.
        back = back if vector.aval.ndim == back.ndim else back.sum(-1)
        return [None, back, *nothing]
    first, second = parts[0].first, parts[0].second
    vector = vector if vector.ndim == given.ndim else vector[:, None]
    if how["differences"]:
        back = (pick(vector, second) - pick(vector, first)) * (
            pick(given, first) - pick(given, second)
        )
    else:
        back = pick(vector, second) * pick(given, first) + pick(vector, first) * pick(given, second)
    return [back if edges.aval.ndim == back.ndim else back.sum(-1), None, *nothing]


def _batch(arguments: Any, axes: Any, *, shape: Any, **how: bool) -> Any:
    *pair, leaves = arguments[0], arguments[1], arguments[2:]
    pattern, rows = jax.tree.unflatten(shape, leaves)
    of_pattern, _ = jax.tree.unflatten(shape, [axis is not None for axis in axes[2:]])
    if any(jax.tree.leaves(of_pattern)):
        raise NotImplementedError("a batch shares one mesh")
    # Padded rows serve one matrix only.
    parts = (pattern, rows if axes[0] is None else None)
    moved = [a if x is None else jnp.moveaxis(a, x, -1) for a, x in zip(pair, axes, strict=False)]
    inner = [array.ndim - 1 - (axis is not None) for array, axis in zip(moved, axes, strict=False)]
    if not any(inner):
        return _bind(moved[0], moved[1], parts, **how), 1
    # The primitive takes one batch axis: a second one is folded into it.
    full = []
    for array, axis, depth in zip(moved, axes, inner, strict=False):
        array = array if depth else jnp.expand_dims(array, 1)
        full.append(array if axis is not None else array[..., None])
    wide = jnp.broadcast_shapes(full[0].shape[1:], full[1].shape[1:])
    flat = [jnp.broadcast_to(a, (a.shape[0], *wide)).reshape(a.shape[0], -1) for a in full]
    out = _bind(flat[0], flat[1], (pattern, None), **how)
    return out.reshape(out.shape[0], *wide), 2


ad.primitive_jvps[_product_p] = _jvp
ad.primitive_transposes[_product_p] = _transpose
batching.primitive_batchers[_product_p] = _batch
mlir.register_lowering(_product_p, mlir.lower_fun(_rows, multiple_results=False))


def edge_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"],
    edges: Float[Array, " edges"],
    vector: Float[Array, " nodes"],
    rows: Rows | None = None,
    *,
    single: bool = False,
) -> Float[Array, " nodes"]:
    """Matrix times vector, from its diagonal and its edges: in [W] for W/K times K, for example.

    `rows`, the same edges padded row by row, are faster to multiply with where they are at hand;
    derivatives flow through `edges`. `single`: whether a batch of edges may be rounded.
    """
    return diagonal_product(diagonal, vector) + _bind(
        edges, vector, (pattern, rows), differences=False, single=single
    )


def difference_product(
    pattern: Pattern,
    edges: Float[Array, " edges"],
    vector: Float[Array, " nodes"],
    rows: Rows | None = None,
    *,
    single: bool = False,
) -> Float[Array, " nodes"]:
    """Product with a matrix whose rows sum to zero, from differences only.

    Constants give exactly zero, which keeps a body at rest at rest to the last bit. `rows` and
    `single` as for `edge_product`.
    """
    return _bind(edges, vector, (pattern, rows), differences=True, single=single)

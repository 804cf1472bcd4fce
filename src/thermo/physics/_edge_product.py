"""Products with a symmetric matrix given by its edges, as one primitive of the compiler's.

Written with gathers and scatters such a product is slow: the scatter runs entry by entry, and a
batch of tangents is laid out with each direction apart. As a primitive it is linear in the edges
and in the vector, its own transpose in the vector, and a batch of either is laid out with the
directions of a node side by side, so that one gather serves them all.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float

from thermo.physics._pattern import Pattern, split_rows


def _rows(
    edges: Array, vector: Array, *leaves: Any, shape: Any, differences: bool
) -> Float[Array, "nodes *batch"]:
    """Sum over the neighbours of each node, group by group of equally long rows."""
    pattern: Pattern = jax.tree.unflatten(shape, leaves)
    batch = max(edges.ndim, vector.ndim) - 1
    # Padded entries point past the last edge, at zero.
    edges = jnp.concatenate([edges, jnp.zeros((1, *edges.shape[1:]), edges.dtype)])
    edges = edges.reshape(*edges.shape, *(1,) * (batch + 1 - edges.ndim))
    vector = vector.reshape(*vector.shape, *(1,) * (batch + 1 - vector.ndim))
    wide = jnp.broadcast_shapes(edges.shape[1:], vector.shape[1:])
    sources = split_rows(pattern, jnp.asarray(pattern.source))
    groups = []
    for (low, high), columns, source in zip(pattern.bounds, pattern.columns, sources, strict=True):
        own = vector[low:high]

        def add(total: Array, piece: Any, own: Array = own) -> tuple[Array, None]:
            for edge, column in zip(*piece, strict=True):
                other = vector[column] - own if differences else vector[column]
                total = total + edges[edge] * other
            return total, None

        runs, rest = zip(source, jax.tree.map(jnp.asarray, columns), strict=True)
        total = jnp.zeros((high - low, *wide), jnp.result_type(edges, vector))
        if len(runs[0]):
            total, _ = jax.lax.scan(add, total, runs)
        groups.append(add(total, rest)[0])
    return jnp.concatenate(groups)


_product_p: Any = Primitive("edge_product")
_product_p.def_impl(jax.jit(_rows, static_argnames=("shape", "differences")))


@_product_p.def_abstract_eval
def _abstract(edges: Any, vector: Any, *leaves: Any, shape: Any, differences: bool) -> Any:
    del leaves, shape, differences
    batch = edges.shape[1:] or vector.shape[1:]
    return ShapedArray((vector.shape[0], *batch), jnp.result_type(edges, vector))


def _zero(value: Array) -> Any:
    zero: Any = ad.Zero
    return zero.from_primal_value(value)


def _bind(edges: Array, vector: Array, leaves: Any, settings: Any) -> Array:
    return _product_p.bind(edges, vector, *leaves, **settings)


def _jvp(primals: Any, tangents: Any, **settings: Any) -> Any:
    edges, vector, *leaves = primals
    terms = []
    if not isinstance(tangents[0], ad.Zero):
        terms.append(_bind(tangents[0], vector, leaves, settings))
    if not isinstance(tangents[1], ad.Zero):
        terms.append(_bind(edges, tangents[1], leaves, settings))
    out = _bind(edges, vector, leaves, settings)
    return out, sum(terms) if terms else _zero(out)


def _transpose(
    given: Any, edges: Any, vector: Any, *leaves: Any, shape: Any, differences: bool
) -> Any:
    nothing = [None] * len(leaves)
    if ad.is_undefined_primal(vector):
        settings = {"shape": shape, "differences": differences}
        back = _bind(edges, given, leaves, settings)
        # A vector that served a whole batch of edges answers for all of it.
        back = back if vector.aval.ndim == back.ndim else back.sum(-1)
        return [None, back, *nothing]
    pattern: Pattern = jax.tree.unflatten(shape, leaves)
    first, second = pattern.first, pattern.second
    vector = vector if vector.ndim == given.ndim else vector[:, None]
    if differences:
        back = (vector[second] - vector[first]) * (given[first] - given[second])
    else:
        back = vector[second] * given[first] + vector[first] * given[second]
    return [back if edges.aval.ndim == back.ndim else back.sum(-1), None, *nothing]


def _batch(arguments: Any, axes: Any, **settings: Any) -> Any:
    *pair, leaves = arguments[0], arguments[1], arguments[2:]
    if any(axis is not None for axis in axes[2:]):
        raise NotImplementedError("a batch shares one mesh")
    moved = [a if x is None else jnp.moveaxis(a, x, -1) for a, x in zip(pair, axes, strict=False)]
    inner = [array.ndim - 1 - (axis is not None) for array, axis in zip(moved, axes, strict=False)]
    if not any(inner):
        return _bind(moved[0], moved[1], leaves, settings), 1
    # The primitive takes one batch axis: a second one is folded into it.
    full = []
    for array, axis, depth in zip(moved, axes, inner, strict=False):
        array = array if depth else jnp.expand_dims(array, 1)
        full.append(array if axis is not None else array[..., None])
    wide = jnp.broadcast_shapes(full[0].shape[1:], full[1].shape[1:])
    flat = [jnp.broadcast_to(a, (a.shape[0], *wide)).reshape(a.shape[0], -1) for a in full]
    out = _bind(flat[0], flat[1], leaves, settings)
    return out.reshape(out.shape[0], *wide), 2


ad.primitive_jvps[_product_p] = _jvp
ad.primitive_transposes[_product_p] = _transpose
batching.primitive_batchers[_product_p] = _batch
mlir.register_lowering(_product_p, mlir.lower_fun(_rows, multiple_results=False))


def _product(pattern: Pattern, edges: Array, vector: Array, *, differences: bool) -> Array:
    leaves, shape = jax.tree.flatten(pattern)
    return _bind(edges, vector, leaves, {"shape": shape, "differences": differences})


def edge_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"],
    edges: Float[Array, " edges"],
    vector: Float[Array, " nodes"],
) -> Float[Array, " nodes"]:
    """Matrix times vector, from its diagonal and its edges: in [W] for W/K times K, for example."""
    return diagonal * vector + _product(pattern, edges, vector, differences=False)


def difference_product(
    pattern: Pattern, edges: Float[Array, " edges"], vector: Float[Array, " nodes"]
) -> Float[Array, " nodes"]:
    """Product with a matrix whose rows sum to zero, from differences only.

    Constants give exactly zero, which keeps a body at rest at rest to the last bit.
    """
    return _product(pattern, edges, vector, differences=True)

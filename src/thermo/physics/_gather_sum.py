"""Sums over fixed groups of values, and their transpose, both by gathers.

Scattered additions run entry by entry; a gather of up to a dozen values for each result runs over
many results at once. The map and its transpose are both stored, so that a derivative in either
direction is such a gather again, and a batch of tangents is laid out with its directions side by
side.
"""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float, Int, Shaped


@final
class GatherSum(eqx.Module):
    """y_i = sum over j in group i of x_j, for values of which the last ones are zero.

    - `groups`: for each result the values to add, (most, results), padded with one that is zero.
    - `back`: the same for the transpose, (often, values).
    """

    groups: Int[Array | np.ndarray, "most results"]
    back: Int[Array | np.ndarray, "often values"]

    def transpose(self) -> GatherSum:
        """The map from results to values, x_j = sum of the y_i that took it."""
        return GatherSum(self.back, self.groups)


def gather_to(target: Int[np.ndarray, " values"], count: int, spare: int) -> GatherSum:
    """The map that adds each value to the result with the given number.

    Arguments:

    - `target`: results of the values, of which each of the `count` [1] has one or more.
    - `spare`: how many zeros follow the values [1], at least one. What the transpose says of
      them means nothing.
    """
    order = np.argsort(target, kind="stable")
    size = np.bincount(target, minlength=count)
    place = np.arange(len(target)) - np.repeat(np.cumsum(size) - size, size)
    groups = np.full((int(size.max()), count), len(target), np.int32)
    groups[place, target[order]] = order
    back = np.concatenate([target, np.zeros(spare, int)]).astype(np.int32)
    return GatherSum(groups, back[None])


def pick(
    values: Shaped[Array, "values *batch"], places: Int[Array | np.ndarray, "*some"]
) -> Shaped[Array, "*some *batch"]:
    """Values at places that are all there and not negative, which nothing then checks [1]."""
    return values.at[places].get(mode="promise_in_bounds", wrap_negative_indices=False)


def _apply(values: Array, groups: Array, back: Array) -> Array:
    del back
    total = pick(values, groups[0])
    for member in groups[1:]:
        total = total + pick(values, member)
    return total


_gather_p: Any = Primitive("gather_sum")
_gather_p.def_impl(jax.jit(_apply))


@_gather_p.def_abstract_eval
def _abstract(values: Any, groups: Any, back: Any) -> Any:
    del back
    return ShapedArray((groups.shape[1], *values.shape[1:]), values.dtype)


def _jvp(primals: Any, tangents: Any) -> Any:
    values, groups, back = primals
    out = _gather_p.bind(values, groups, back)
    zero: Any = ad.Zero
    if isinstance(tangents[0], ad.Zero):
        return out, zero.from_primal_value(out)
    return out, _gather_p.bind(tangents[0], groups, back)


def _transpose(given: Any, values: Any, groups: Any, back: Any) -> Any:
    del values
    return [_gather_p.bind(given, back, groups), None, None]


def _batch(arguments: Any, axes: Any) -> Any:
    values, groups, back = arguments
    if axes[1] is not None or axes[2] is not None:
        raise NotImplementedError("a batch shares one mesh")
    moved = jnp.moveaxis(values, axes[0], -1)
    return _gather_p.bind(moved, groups, back), moved.ndim - 1


ad.primitive_jvps[_gather_p] = _jvp
ad.primitive_transposes[_gather_p] = _transpose
batching.primitive_batchers[_gather_p] = _batch
mlir.register_lowering(_gather_p, mlir.lower_fun(_apply, multiple_results=False))


def gather_sum(which: GatherSum, values: Float[Array, " values"]) -> Float[Array, " results"]:
    """Apply the map; the unit stays."""
    return _gather_p.bind(values, jnp.asarray(which.groups), jnp.asarray(which.back))

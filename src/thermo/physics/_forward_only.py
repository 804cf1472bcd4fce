"""Runs for forward derivatives alone, many of them together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp

from thermo.physics._adjoint import AbstractAdjoint


@final
class ForwardOnly(AbstractAdjoint):
    """No reverse pass; many tangents go through each step together, side by side at each node.

    A plain batch of derivatives puts the directions apart, one whole body after the other, and
    each product then gathers from far. Here a batch made by `jax.vmap` of `jax.jvp` runs as one.
    """

    def run(self, step: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `step` over the leading axis of `inputs`, which are the same for all tangents.

        Raises `NotImplementedError` where `inputs` have tangents.
        """
        one = jax.tree.map(lambda a: a[0], inputs)
        return _march(eqx.filter_closure_convert(step, start, one), start, inputs)

    def stages(self, stage: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """The same: a plain loop would put the directions apart in each step."""
        return self.run(stage, start, inputs)


@eqx.filter_custom_jvp
def _march(step: Any, start: Any, inputs: Any) -> Any:
    # Where nothing moves, as by errors of readings alone, JAX hashes what is scanned.
    return jax.lax.scan(lambda state, one: step(state, one), start, inputs)


@_march.def_jvp
def _(primals: Any, tangents: Any) -> Any:
    given, fixed = eqx.partition(primals, eqx.is_array)
    of_step, of_start, of_inputs = tangents
    if jax.tree.leaves(of_inputs):
        raise NotImplementedError(
            "what each step is given is the same for all tangents: hand on what changes as state"
        )

    def run(given: Any, change: Any, wide: bool) -> Any:
        """All steps and their tangents; where these are `wide`, the last axis is their batch."""
        step, start, inputs = eqx.combine(given, fixed)
        of_step, of_start = change

        def body(carry: Any, piece: Any) -> Any:
            state, moved = carry

            def along(of_step: Any, moved: Any) -> Any:
                new, change = eqx.filter_jvp(
                    lambda s, x: s(x, piece), (step, state), (of_step, moved)
                )
                return new, _filled(new, change)

            if wide:
                along = jax.vmap(along, in_axes=(-1, -1), out_axes=(None, -1))
            (new, out), (after, change) = along(of_step, moved)
            return (new, after), (out, change)

        (last, after), (out, change) = jax.lax.scan(body, (start, of_start), inputs)
        return (last, out), (after, change)

    @jax.custom_batching.custom_vmap
    def pair(given: Any, change: Any) -> Any:
        return run(given, change, wide=False)

    @pair.def_vmap
    def together(size: int, batched: Any, given: Any, change: Any) -> Any:
        if any(jax.tree.leaves(batched[0])):
            axes = jax.tree.map(lambda flag: 0 if flag else None, batched)
            both = jax.vmap(lambda g, c: run(g, c, wide=False), in_axes=tuple(axes))(given, change)
            return both, jax.tree.map(lambda _: True, both)

        def last(value: Any, flag: bool) -> Any:
            if flag:
                return jnp.moveaxis(value, 0, -1)
            return jnp.broadcast_to(value[..., None], (*value.shape, size))

        out, after = run(given, jax.tree.map(last, change, batched[1]), wide=True)
        after = jax.tree.map(lambda value: jnp.moveaxis(value, -1, 0), after)
        flags = (jax.tree.map(lambda _: False, out), jax.tree.map(lambda _: True, after))
        return (out, after), flags

    return pair(given, (of_step, _filled(primals[1], of_start)))


def _filled(values: Any, change: Any) -> Any:
    """Tangents with zeros in place of those that are symbolically zero."""

    def fill(value: Any, tangent: Any) -> Any:
        missing = tangent is None and eqx.is_inexact_array(value)
        return jnp.zeros_like(value) if missing else tangent

    return jax.tree.map(fill, values, change, is_leaf=lambda x: x is None)

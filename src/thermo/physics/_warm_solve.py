"""Solves of a step's matrix that begin from what the steps before it found.

One primitive serves the temperatures, their tangents and their adjoints. It takes a right-hand
side and the solutions of the steps before, of all solves of a step, and gives the solution and
those solutions with it in place of the oldest of its own. Differentiated, the second part carries
the solutions of the steps before for the tangents; transposed, it carries those of the steps after
for the adjoint: all three begin where their own neighbours in time point. The solution does not
depend on where it began, but for the tolerance, so that the derivative of the first part is a solve
again and nothing else.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Bool, Float, Int

from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Memory, Outlook
from thermo.physics._step_matrix import StepMatrix

VALUE, TANGENT, ADJOINT = "value", "tangent", "adjoint"
"""What is solved for; the transpose of a tangent's solve is an adjoint's."""


Solved = tuple[Float[Array, " nodes"], Memory, Bool[Array, ""]]


def _solve(heat: Array, past: Array, largest: Array, *leaves: Any, shape: Any, role: str) -> Any:
    matrix, solver, outlook, which = jax.tree.unflatten(shape, leaves)
    rates = jax.lax.dynamic_index_in_dim(past, which, keepdims=False)
    most = jax.lax.dynamic_index_in_dim(largest, which, keepdims=False)
    weights = outlook.back if role == ADJOINT else outlook.ahead * outlook.size
    if role != VALUE:
        # What decays to nothing within a run need not be known to as many digits of itself.
        scaled = heat / jnp.expand_dims(matrix.diagonal, range(1, heat.ndim))
        most = jnp.maximum(most, jnp.sum(heat * scaled, axis=0))
    guess = sum(weight * rate for weight, rate in zip(weights, rates, strict=True))
    solve = solver.solve_together if heat.ndim > 1 else solver.solve
    found, fine, _ = solve(matrix, heat, guess, most)
    # A step of no duration leaves no rate.
    whole = jnp.where(outlook.size > 0, outlook.size, jnp.inf)
    latest = found if role == ADJOINT else found / whole
    place = [jnp.asarray(at, int) for at in (which, outlook.place, *[0] * latest.ndim)]
    past = jax.lax.dynamic_update_slice(past, latest.astype(past.dtype)[None, None], place)
    return found, past, jax.lax.dynamic_update_index_in_dim(largest, most, which, 0), fine


_solve_p: Any = Primitive("warm_solve")
_solve_p.multiple_results = True
_solve_p.def_impl(jax.jit(_solve, static_argnames=("shape", "role")))


@_solve_p.def_abstract_eval
def _abstract(heat: Any, past: Any, largest: Any, *leaves: Any, shape: Any, role: str) -> Any:
    del leaves, shape, role
    same = tuple(ShapedArray(a.shape, a.dtype) for a in (heat, past, largest))
    return *same, ShapedArray((), jnp.dtype(bool))


def _transpose(
    given: Any, heat: Any, past: Any, largest: Any, *leaves: Any, shape: Any, role: str
) -> Any:
    filled = [ad.instantiate_zeros(value) for value in given[:3]]
    turned = {TANGENT: ADJOINT, ADJOINT: TANGENT}[role]
    back = _solve_p.bind(*filled, *leaves, shape=shape, role=turned)
    asked = [ad.is_undefined_primal(value) for value in (heat, past, largest)]
    known = [value if ask else None for value, ask in zip(back, asked, strict=False)]
    return [*known, *[None] * len(leaves)]


def _batch(arguments: Any, axes: Any, *, shape: Any, role: str) -> Any:
    size = next(a.shape[x] for a, x in zip(arguments, axes, strict=True) if x is not None)

    def bind(*each: Any) -> Any:
        return _solve_p.bind(*each, shape=shape, role=role)

    if any(axis is not None for axis in axes[3:]) or arguments[0].ndim > 2:
        # Other matrices, or a batch of batches: one after the other is faster than side by side.
        full = [
            jnp.broadcast_to(a, (size, *a.shape)) if x is None else jnp.moveaxis(a, x, 0)
            for a, x in zip(arguments, axes, strict=True)
        ]
        return jax.lax.map(lambda each: bind(*each), full), (0, 0, 0, 0)
    wide = [
        jnp.broadcast_to(a[..., None], (*a.shape, size)) if x is None else jnp.moveaxis(a, x, -1)
        for a, x in zip(arguments[:3], axes[:3], strict=True)
    ]
    return bind(*wide, *arguments[3:]), (1, 3, 1, None)


ad.primitive_transposes[_solve_p] = _transpose
batching.primitive_batchers[_solve_p] = _batch
mlir.register_lowering(_solve_p, mlir.lower_fun(_solve, multiple_results=True))


def _bind(
    role: str,
    matrix: StepMatrix,
    heat: Float[Array, " nodes"],
    past: Memory,
    which: Int[Array | np.ndarray, ""],
    solver: ConjugateGradient,
    outlook: Outlook,
) -> Solved:
    """Solution [K] for a right-hand side [J], the next past, and whether it converged.

    `which`: of a step's solves this is [1].
    """
    leaves, shape = jax.tree.flatten((matrix, solver, outlook, jnp.asarray(which)))
    parts = (heat, past.found, past.largest)
    found, steps, largest, fine = _solve_p.bind(*parts, *leaves, shape=shape, role=role)
    return found, Memory(steps, largest), fine


warm_solve = partial(_bind, VALUE)
"""For temperatures. It has no derivative of its own: `tangent_solve` is part of that."""

tangent_solve = partial(_bind, TANGENT)
"""For a tangent, linear in `heat` and `past` together; its transpose is an adjoint's.

The tolerance is relative to the largest right-hand side of the run so far: tangents matter beside
each other, and what has decayed to nothing need not be known to digits of its own.
"""

"""Solves of a step's matrix that begin from what the steps before it found.

One primitive serves the temperatures, their tangents and their adjoints. It takes a right-hand
side and the solutions of the steps before, and gives the solution and those solutions with it in
place of the oldest. Differentiated, the second part carries the solutions of the steps before for
the tangents; transposed, it carries those of the steps after for the adjoint: all three begin
where their own neighbours in time point. The solution does not depend on where it began, but for
the tolerance, so that the derivative of the first part is a solve again and nothing else.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Bool, Float

from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Outlook
from thermo.physics._step_matrix import StepMatrix


def _solve(heat: Array, past: Array, *leaves: Any, shape: Any, transposed: bool) -> Any:
    matrix, solver, outlook = jax.tree.unflatten(shape, leaves)
    weights = outlook.back if transposed else outlook.ahead * outlook.size
    guess = jnp.tensordot(weights, past, 1)
    found, fine, _ = solver.solve(matrix, heat, guess)
    # A step of no duration leaves no rate.
    whole = jnp.where(outlook.size > 0, outlook.size, jnp.inf)
    latest = found if transposed else found / whole
    return found, past.at[outlook.place].set(latest), fine


_solve_p: Any = Primitive("warm_solve")
_solve_p.multiple_results = True
_solve_p.def_impl(jax.jit(_solve, static_argnames=("shape", "transposed")))


@_solve_p.def_abstract_eval
def _abstract(heat: Any, past: Any, *leaves: Any, shape: Any, transposed: bool) -> Any:
    del leaves, shape, transposed
    return (
        ShapedArray(heat.shape, heat.dtype),
        ShapedArray(past.shape, past.dtype),
        ShapedArray((), jnp.dtype(bool)),
    )


def _filled(value: Any) -> Array:
    return ad.instantiate_zeros(value)


def _transpose(given: Any, heat: Any, past: Any, *leaves: Any, shape: Any, transposed: bool) -> Any:
    found, later, _ = given
    back = _solve_p.bind(
        _filled(found), _filled(later), *leaves, shape=shape, transposed=not transposed
    )
    wanted = [ad.is_undefined_primal(value) for value in (heat, past)]
    pair = [value if ask else None for value, ask in zip(back, wanted, strict=False)]
    return [*pair, *[None] * len(leaves)]


def _batch(arguments: Any, axes: Any, *, shape: Any, transposed: bool) -> Any:
    size = next(a.shape[x] for a, x in zip(arguments, axes, strict=True) if x is not None)

    def bind(heat: Array, past: Array, *leaves: Any) -> Any:
        return _solve_p.bind(heat, past, *leaves, shape=shape, transposed=transposed)

    if any(axis is not None for axis in axes[2:]) or arguments[0].ndim > 2:
        # Other matrices, or a batch of batches: one after the other is faster than side by side.
        full = [
            jnp.broadcast_to(a, (size, *a.shape)) if x is None else jnp.moveaxis(a, x, 0)
            for a, x in zip(arguments, axes, strict=True)
        ]
        return jax.lax.map(lambda each: bind(*each), full), (0, 0, 0)
    heat, past = (
        jnp.broadcast_to(a[..., None], (*a.shape, size)) if x is None else jnp.moveaxis(a, x, -1)
        for a, x in zip(arguments[:2], axes[:2], strict=True)
    )
    return bind(heat, past, *arguments[2:]), (1, 2, None)


ad.primitive_transposes[_solve_p] = _transpose
batching.primitive_batchers[_solve_p] = _batch
mlir.register_lowering(_solve_p, mlir.lower_fun(_solve, multiple_results=True))


def warm_solve(
    matrix: StepMatrix,
    heat: Float[Array, " nodes"],
    past: Float[Array, "depth nodes"],
    solver: ConjugateGradient,
    outlook: Outlook,
) -> tuple[Float[Array, " nodes"], Float[Array, "depth nodes"], Bool[Array, ""]]:
    """Solution [K] for a right-hand side [J], the past of the next step, and whether it converged.

    Linear in `heat` and `past` together, and its own transpose.
    """
    leaves, shape = jax.tree.flatten((matrix, solver, outlook))
    return tuple(_solve_p.bind(heat, past, *leaves, shape=shape, transposed=False))

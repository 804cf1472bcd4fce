"""What the reverse pass of a simulation keeps in memory."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp

from thermo.errors import InputError


def _keep_solutions(primitive: Any, *_: Any, **__: Any) -> bool:
    # The reverse pass then never repeats a linear solve.
    return primitive.name == "warm_solve"


def _written_out(stage: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
    """Like `jax.lax.scan`, whose reverse pass takes a third longer within a step."""
    outputs = []
    for number in range(len(jax.tree.leaves(inputs)[0])):
        start, output = stage(start, jax.tree.map(lambda a, at=number: a[at, ...], inputs))
        outputs.append(output)
    return start, jax.tree.map(lambda *each: jnp.stack(each), *outputs)


class AbstractAdjoint(eqx.Module):
    """How the steps of a simulation are run so that they can be differentiated."""

    @abstractmethod
    def run(self, step: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `step` over the leading axis of `inputs`, like `jax.lax.scan`; [1] a step."""

    @abstractmethod
    def stages(self, stage: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """The same for the stages of one step, which `run` differentiates as part of it."""


@final
class StoreSteps(AbstractAdjoint):
    """Keep the temperatures and increments of every step: memory grows with the steps."""

    def run(self, step: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `step` over the leading axis of `inputs`."""
        kept = jax.checkpoint(step, policy=_keep_solutions, prevent_cse=False)
        return jax.lax.scan(kept, start, inputs)

    def stages(self, stage: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `stage` over the leading axis of `inputs`."""
        return _written_out(stage, start, inputs)


@final
class RecomputeSegments(AbstractAdjoint):
    """Keep one state a segment of `length` steps and run each segment again going back.

    With a length of about the square root of the steps, memory grows with that square root, for
    one more forward run.
    """

    length: int = eqx.field(static=True)

    def __check_init__(self) -> None:
        if self.length < 1:
            raise InputError(
                "a segment needs steps",
                where="RecomputeSegments: length",
                value=self.length,
                limit="at least 1",
                remedy="take about the square root of the number of steps",
            )

    def run(self, step: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `step` over the leading axis of `inputs`, segment by segment."""
        kept = jax.checkpoint(step, policy=_keep_solutions, prevent_cse=False)
        count = jax.tree.leaves(inputs)[0].shape[0]
        whole = count // self.length * self.length

        def segment(state: Any, piece: Any) -> tuple[Any, Any]:
            return jax.lax.scan(kept, state, piece)

        head = jax.tree.map(lambda a: a[:whole].reshape(-1, self.length, *a.shape[1:]), inputs)
        tail = jax.tree.map(lambda a: a[whole:], inputs)
        state, first = jax.lax.scan(jax.checkpoint(segment, prevent_cse=False), start, head)
        state, rest = jax.lax.scan(kept, state, tail)
        flat = jax.tree.map(lambda a: a.reshape(-1, *a.shape[2:]), first)
        return state, jax.tree.map(lambda a, b: jnp.concatenate([a, b]), flat, rest)

    def stages(self, stage: Callable[[Any, Any], Any], start: Any, inputs: Any) -> tuple[Any, Any]:
        """Run `stage` over the leading axis of `inputs`."""
        return _written_out(stage, start, inputs)

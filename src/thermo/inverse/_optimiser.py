"""Optimisers, one step at a time, so that a fit can show progress, stop and go on."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import equinox as eqx
from jaxtyping import Array, Float

from thermo.inverse._objective import Objective, Parameters

Memory = dict[str, Any]


class AbstractOptimiser(eqx.Module):
    """Makes half the sum of squares of the whitened residual small."""

    max_steps: eqx.AbstractVar[int]

    @abstractmethod
    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""

    @abstractmethod
    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with what `memory` kept from an interrupted fit [1]."""

    @abstractmethod
    def memory(self, state: Any) -> Memory:
        """Arrays [1] that suffice, with the parameters, to go on where a fit stopped."""

    @abstractmethod
    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One step: new parameters [1], state, loss [1] at them, and whether it is done."""

    @abstractmethod
    def loss_at_arrival(self) -> bool:
        """Whether the loss [1] of a step is that of the parameters where it ends."""

    @abstractmethod
    def residual(self, state: Any) -> Float[Array, " all"] | None:
        """Whitened residual [1] where a step arrived, None where the state does not hold it."""

    @abstractmethod
    def fixed_length(self) -> bool:
        """Whether it simply makes all its steps [1], with no stopping rule to meet."""

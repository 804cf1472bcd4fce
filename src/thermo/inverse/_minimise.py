"""The loop of a fit: steps, history, best so far, checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

from jaxtyping import Array, Float

from thermo.inverse._checkpoint import (
    Checkpoint,
    Leaves,
    leaves_of,
    load_checkpoint,
    parameters_of,
    save_checkpoint,
)
from thermo.inverse._objective import Objective, Parameters, start, with_fields
from thermo.inverse._optimiser import AbstractOptimiser

OnStep = Callable[[int, int | None, float], None]
"""Called after each step with its number, about how many all stages make, None while nothing tells
that, and the loss [1]."""


Stage = Callable[[Objective | None], Objective | None]
"""Makes the objective of a stage from that of the one before, whose fields stand where it ended;
from None for the first. None where nothing is left to do."""


@final
@dataclass(frozen=True)
class Fit:
    """The end of a fit.

    - `objective`: of the last stage; `parameters`: the best that were met there [1].
    - `loss`: there [1]; `residual`: there, whitened [1], where the optimiser kept it.
    - `history`: loss after each step of each stage [1].
    - `success`: whether the optimiser met its own stopping rule.
    """

    objective: Objective
    parameters: Parameters
    loss: float
    residual: Float[Array, " all"] | None
    history: list[list[float]]
    success: bool


def minimise(
    stages: list[Stage],
    optimiser: AbstractOptimiser,
    *,
    key: str,
    checkpoint: Path | None = None,
    on_step: OnStep | None = None,
) -> Fit:
    """Run an optimiser through the stages, each from where the one before ended.

    Arguments:

    - `stages`: make the objective of each stage; a stage is made when it is reached.
    - `key`: says what is being fitted; a checkpoint of another fit is refused.
    - `checkpoint`: file to go on from, written after every step. It stays at the end, so that
      nothing is lost before the result is safe; who called removes it then.
    - `on_step`: told of every step, with the loss [1].

    A fit that is stopped and started again runs through the same parameters as one that was not.

    Source: paper, appendix B.8 (checklist E6, E7).
    """
    saved = None if checkpoint is None else load_checkpoint(checkpoint, key)
    objective = _made(stages[0](None))
    for number, leaves in enumerate([] if saved is None else saved.ends):
        ended = parameters_of(leaves, start(objective), str(checkpoint))
        objective = _made(stages[number + 1](_standing(objective, ended)))

    def told(history: list[list[float]]) -> None:
        if on_step is not None:
            made = [len(losses) for losses in history]
            on_step(sum(made), _about(optimiser, made, len(stages)), history[-1][-1])

    now = _beginning(key, objective, [], []) if saved is None else saved
    fit = _run_stage(objective, optimiser, now, checkpoint, told)
    while len(now.ends) + 1 < len(stages):
        ends = [*now.ends, leaves_of(fit.parameters)]
        objective = stages[len(ends)](_standing(fit.objective, fit.parameters))
        if objective is None:
            break
        now = _beginning(key, objective, ends, fit.history)
        fit = _run_stage(objective, optimiser, now, checkpoint, told)
    return fit


def _about(optimiser: AbstractOptimiser, made: list[int], stages: int) -> int | None:
    """How many steps all stages make [1], going by those made in each stage so far.

    An optimiser that stops by itself is expected to go as far in the stages to come as it ever did.
    """
    if optimiser.fixed_length():
        return stages * optimiser.max_steps
    *ended, here = made
    if not ended:
        return None
    usual = max(ended)
    return sum(ended) + max(here, usual) + usual * (stages - len(made))


def _made(objective: Objective | None) -> Objective:
    assert objective is not None, "the first stage, and one that was begun, always have work"
    return objective


def _standing(objective: Objective, parameters: Parameters) -> Objective:
    return replace(objective, fields=with_fields(objective, parameters))


def _beginning(
    key: str, objective: Objective, ends: list[Leaves], history: list[list[float]]
) -> Checkpoint:
    here = leaves_of(start(objective))
    return Checkpoint(key, ends, here, here, float("inf"), [*history, []])


def _run_stage(
    objective: Objective,
    optimiser: AbstractOptimiser,
    begun: Checkpoint,
    checkpoint: Path | None,
    told: Callable[[list[list[float]]], None],
) -> Fit:
    like = start(objective)
    parameters, best = (
        parameters_of(leaves, like, str(checkpoint)) for leaves in (begun.parameters, begun.best)
    )
    best_loss = begun.best_loss
    earlier, losses, residual = begun.history[:-1], list(begun.history[-1]), None
    state = optimiser.begin(objective, parameters)
    if begun.memory:
        state = optimiser.resume(state, begun.memory)
    success = optimiser.fixed_length()
    for _ in range(len(losses), optimiser.max_steps):
        before = parameters
        parameters, state, loss, (done, fine) = optimiser.advance(objective, parameters, state)
        losses.append(float(loss))
        if losses[-1] <= best_loss:
            # Least-squares steps report the loss where they arrive, Adam that where it left.
            best, best_loss = (parameters if optimiser.loss_at_arrival() else before), losses[-1]
            residual = optimiser.residual(state)
        history, memory = [*earlier, losses], optimiser.memory(state)
        if checkpoint is not None:
            here, least = leaves_of(parameters), leaves_of(best)
            now = Checkpoint(begun.key, begun.ends, here, least, best_loss, history, memory)
            save_checkpoint(checkpoint, now)
        told(history)
        if bool(done):
            success = bool(fine)
            break
    return Fit(objective, best, best_loss, residual, [*earlier, losses], success)

"""The loop of a fit: steps, history, best so far, checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from thermo.inverse._checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from thermo.inverse._objective import Objective, Parameters, start
from thermo.inverse._optimiser import AbstractOptimiser

OnStep = Callable[[int, int, float], None]
"""Called after each step with its number, the most steps there can be, and the loss [1]."""


@final
@dataclass(frozen=True)
class Fit:
    """The end of a fit.

    - `parameters`: the best that were met [1]; `loss`: there [1].
    - `history`: loss after each step, a list for each stage [1].
    - `success`: whether the optimiser met its own stopping rule.
    """

    parameters: Parameters
    loss: float
    history: list[list[float]]
    success: bool


def minimise(
    stages: list[Callable[[], Objective]],
    optimiser: AbstractOptimiser,
    *,
    key: str,
    checkpoint: Path | None = None,
    on_step: OnStep | None = None,
) -> Fit:
    """Run an optimiser through the stages, each from exactly the field of the one before.

    Arguments:

    - `stages`: make the objective of each stage; a stage is made when it is reached.
    - `key`: says what is being fitted; a checkpoint of another fit is refused.
    - `checkpoint`: file to go on from, written after every step and deleted at the end.
    - `on_step`: told of every step, with the loss [1].

    A fit that is stopped and started again runs through the same parameters as one that was not.

    Source: paper, appendix B.8 (checklist E6, E7).
    """
    objective = stages[0]()
    saved = None
    if checkpoint is not None:
        saved = load_checkpoint(checkpoint, key, start(objective))
    first = 0 if saved is None else saved.stage
    history = [] if saved is None else saved.history[:first]
    parameters = start(objective) if saved is None else saved.parameters
    result = None
    for stage in range(first, len(stages)):
        objective = objective if stage == 0 else stages[stage]()
        if saved is not None and stage == first:
            resumed = saved
        else:
            resumed = Checkpoint(key, stage, parameters, parameters, float("inf"), [])
        losses = list(saved.history[stage]) if resumed is saved and saved is not None else []

        def keep(state: Checkpoint) -> None:
            if checkpoint is not None:
                save_checkpoint(checkpoint, state)

        result = _run_stage(objective, optimiser, resumed, history, losses, keep, on_step)
        parameters, history = result.parameters, result.history
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    if result is None:
        raise ValueError("a fit has at least one stage")
    return result


def _run_stage(
    objective: Objective,
    optimiser: AbstractOptimiser,
    begun: Checkpoint,
    earlier: list[list[float]],
    losses: list[float],
    keep: Callable[[Checkpoint], None],
    on_step: OnStep | None,
) -> Fit:
    parameters, best, best_loss = begun.parameters, begun.best, begun.best_loss
    state = optimiser.begin(objective, parameters)
    if begun.memory:
        state = optimiser.resume(state, begun.memory)
    success = optimiser.fixed_length()
    for count in range(len(losses), optimiser.max_steps):
        before = parameters
        parameters, state, loss, (done, fine) = optimiser.advance(objective, parameters, state)
        losses.append(float(loss))
        if losses[-1] <= best_loss:
            # Least-squares steps report the loss where they arrive, Adam that where it left.
            best, best_loss = (parameters if optimiser.loss_at_arrival() else before), losses[-1]
        keep(
            Checkpoint(
                begun.key,
                begun.stage,
                parameters,
                best,
                best_loss,
                [*earlier, losses],
                optimiser.memory(state),
            )
        )
        if on_step is not None:
            on_step(count + 1, optimiser.max_steps, losses[-1])
        if bool(done):
            success = bool(fine)
            break
    return Fit(best, best_loss, [*earlier, losses], success)

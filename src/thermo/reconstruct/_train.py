"""Training of a surface on photographs, step after step, to be interrupted and resumed."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, NamedTuple, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float, Int, PRNGKeyArray

from ._checkpoint import load_checkpoint, question, save_checkpoint
from ._neural_surface import NeuralSurface
from ._objective import Parts, objective
from ._photograph import Photograph
from ._pixels import Pixels, pixels_of
from ._region import Region
from ._training import Training, open_levels, optimiser

_CHUNK: Final = 50
"""Steps of one compiled loop [1]: calling it costs nothing, and it can be stopped."""
_KEPT: Final = 60.0
"""After so long a checkpoint is written, for processes that are ended without notice [s]."""


@final
class Trained(eqx.Module):
    """A surface as photographs taught it.

    - `surface`: distance, colour and sharpness, in the region's unit.
    - `region`: the cube that it was looked for in.
    - `psnr`: of the pixels of each step, (steps,) [dB].
    """

    surface: NeuralSurface
    region: Region
    psnr: Float[np.ndarray, " steps"]


class State(NamedTuple):
    """What a step changes."""

    surface: NeuralSurface
    memory: optax.OptState


def train(
    photographs: Sequence[Photograph],
    region: Region,
    training: Training,
    *,
    checkpoint: Path | None = None,
    on_step: Callable[[int, int, float], None] = lambda *_: None,
) -> Trained:
    """Minimise the objective by Adam on rays that are drawn anew at each step.

    Arguments:

    - `photographs`: calibrated; of all of them masks are known, or of none.
    - `region`: a cube [m] that holds the object.
    - `training`: sizes and rates.
    - `checkpoint`: file that an interrupted training leaves, and goes on from.
    - `on_step`: told steps made, steps in all and PSNR [dB] after every few steps.

    Raises `InputError` as `pixels_of` does, and for a checkpoint of another training.

    Source: paper, section 4.1 and appendix B.1; Wang et al., NeurIPS 2021 (NeuS).
    """
    pixels = pixels_of(photographs, region)
    first, draws = jax.random.split(jax.random.key(training.seed))
    surface = NeuralSurface(
        training.cells, training.features, training.width, training.told,
        masked=pixels.masked, key=first,
    )  # fmt: skip
    state = State(surface, optimiser(training).init(eqx.filter(surface, eqx.is_array)))
    asked = question(pixels, training)
    stored = None if checkpoint is None else load_checkpoint(checkpoint, asked, state)
    state, squares = (state, np.zeros(0)) if stored is None else stored
    saved = time.monotonic()
    try:
        while len(squares) < training.steps:
            count = min(_CHUNK, training.steps - len(squares))
            numbers = len(squares) + jnp.arange(count)
            state, parts = _steps(state, pixels, training, numbers, draws)
            squares = np.concatenate([squares, np.asarray(parts.square)])
            on_step(len(squares), training.steps, float(_decibels(squares[-count:]).mean()))
            if checkpoint is not None and time.monotonic() > saved + _KEPT:
                save_checkpoint(checkpoint, asked, state, squares)
                saved = time.monotonic()
    finally:
        # Whatever stopped it: what stands here is whole.
        if checkpoint is not None:
            save_checkpoint(checkpoint, asked, state, squares)
    return Trained(state.surface, region, _decibels(squares))


def distance_of(trained: Trained) -> Callable[[Float[Array, "points 3"]], Float[Array, " points"]]:
    """The distance [1] at places of [-1, 1]^3, in halves of the region's edge; compiled once."""
    levels = jnp.asarray(len(trained.surface.distance.encoding.cells), jnp.float32)

    @eqx.filter_jit
    def distance(places: Float[Array, "points 3"]) -> Float[Array, " points"]:
        return trained.surface.distance(places.astype(jnp.float32), levels)[0]

    return distance


def _decibels(square: Float[np.ndarray, "*steps"]) -> Float[np.ndarray, "*steps"]:
    return -10.0 * np.log10(np.maximum(square, 1e-12))


@eqx.filter_jit
def _steps(
    state: State,
    pixels: Pixels,
    training: Training,
    numbers: Int[Array, " steps"],
    draws: PRNGKeyArray,
) -> tuple[State, Parts]:
    """Some steps, with the parts of the objective at each."""
    adam = optimiser(training)

    def step(state: State, number: Int[Array, ""]) -> tuple[State, Parts]:
        first, second = jax.random.split(jax.random.fold_in(draws, number))
        (_, parts), slope = eqx.filter_value_and_grad(objective, has_aux=True)(
            state.surface, pixels.drawn(training.rays, first), training.sampling,
            training.balance, open_levels(training, number), key=second,
        )  # fmt: skip
        change, memory = adam.update(slope, state.memory)
        return State(eqx.apply_updates(state.surface, change), memory), parts

    return jax.lax.scan(step, state, numbers)

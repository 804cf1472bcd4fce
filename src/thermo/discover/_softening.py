"""What cells and steps may still make wrong: smooth shapes count for less."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.linalg import block_diag

from thermo._compiled import program
from thermo.discover._bench import Apart
from thermo.discover._extended import whitened
from thermo.discover._modes import space_modes, time_modes
from thermo.discover.candidates._between_frames import between_frames
from thermo.inverse import DEFECT_LEFT, Objective, Task
from thermo.observe import variance_error

STAMP: Final = 0.02
"""Standard deviation of what the stamps of a run's frames may all be off by, over the distance of
frames [1]: exposure, read-out and the lamp's switch are known no better."""

# Deviations within which the level of the noise is [1].
_SURE: Final = 3.0


@final
@dataclass(frozen=True)
class Block:
    """The values of one run in the residual.

    - `name`; `part`; `shape`: (frames, samples) [1].
    - `in_time` (frames, modes), `in_space` (samples, modes): smooth shapes [1].
    - `share`: of a smooth shape that is taken off, in units of its noise [1].
    - `level`: how many times as large as estimated the noise's variance may be [1].
    - `readings`: how many values were read, not left out and not beyond the run's end [1].
    """

    name: str
    part: slice
    shape: tuple[int, int]
    in_time: Float[np.ndarray, "frames time"]
    in_space: Float[np.ndarray, "samples space"]
    share: float
    level: float
    readings: int

    def coefficients(
        self, values: Float[np.ndarray, "values *columns"]
    ) -> Float[np.ndarray, "time space *columns"]:
        """Of whitened values [1], or of columns of them, those of the smooth shapes."""
        part = values[self.part].reshape(*self.shape, *values.shape[1:])
        along = np.tensordot(self.in_time.T, part, 1)
        return np.moveaxis(np.tensordot(self.in_space.T, along, (1, 1)), 0, 1)


def blocks(objective: Objective, task: Task, left: Apart) -> list[Block]:
    """The runs of an objective, and how far each is to be softened.

    A third of what cells and steps make wrong, `left` [K], may be left in the finer runs that the
    residual is measured against, and the task's `model_error` [K] comes from elsewhere: geometry,
    lamps, clocks. Both are spread at random over the smooth shapes: the variance of each is
    1 + tau^2, tau^2 the energy of those errors over the number of shapes.

    Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """
    found, begin, order = [], 0, iter(objective.sequence)
    for case, group in zip(objective.cases, left, strict=True):
        for used, weight, apart, when in zip(
            np.asarray(case.used), np.asarray(case.weight()), np.asarray(group),
            np.asarray(case.time), strict=True,
        ):  # fmt: skip
            run = task.runs[next(order)]
            points = run.recording.points
            modes = space_modes(points)
            across = np.zeros((used.shape[1], modes.shape[1]))
            across[: len(points)] = modes
            # Beyond its end, where longer runs beside it go on, nothing is smooth: shapes that
            # reached there would hold less of its noise than their number says.
            own = time_modes(_own_frames(when))
            along = np.zeros((len(used), own.shape[1]))
            along[: len(own)] = own
            wrong = (DEFECT_LEFT * apart) ** 2 + task.model_error**2
            energy = float(np.sum(weight**2 * used * wrong))
            spread = energy / (along.shape[1] * across.shape[1])
            share = 1 - 1 / np.sqrt(1 + spread)
            part = slice(begin, begin + used.size)
            level = 1 + _SURE * variance_error(run.recording)
            read = int(np.count_nonzero(used))
            found.append(Block(run.name, part, used.shape, along, across, share, level, read))
            begin += used.size
    return found


def _own_frames(when: Float[np.ndarray, " frames"]) -> int:
    """Of times [s], how many are a run's own [1]: those that it lacks repeat its last one."""
    return len(np.unique(when))


def softened(
    runs: list[Block], values: Float[np.ndarray, "values columns"]
) -> Float[np.ndarray, "values columns"]:
    """Whitened columns [1] with the smooth shapes' share taken off, whose variance is one then."""
    made = np.array(values)
    for block in runs:
        # All columns at once, in place: they are long, and memory is what this costs.
        part = made[block.part].reshape(*block.shape, -1)
        along = np.tensordot(block.in_time.T, part, 1)
        across = block.in_space @ (block.share * (block.in_space.T @ along))
        part -= np.tensordot(block.in_time, across, 1)
    return made


def in_shapes(
    runs: list[Block], values: Float[np.ndarray, "values columns"]
) -> Float[np.ndarray, "shapes columns"]:
    """Coefficients of the smooth shapes of all runs, one after the other, in each column [1]."""
    count = values.shape[1]
    return np.concatenate([block.coefficients(values).reshape(-1, count) for block in runs])


def shape_products(runs: list[Block]) -> Float[np.ndarray, "shapes shapes"]:
    """Products of the smooth shapes with each other [1], in the order of `in_shapes`."""
    each = (
        np.kron(block.in_time.T @ block.in_time, block.in_space.T @ block.in_space)
        for block in runs
    )
    return np.asarray(block_diag(*each))


def omnibus(
    runs: list[Block], values: Float[np.ndarray, " values"]
) -> tuple[float, int, Mapping[str, float]]:
    """Sum of squares in the smooth shapes, their number, and the sum of each run [1]."""
    each = {block.name: float(np.sum(block.coefficients(values) ** 2)) for block in runs}
    count = sum(block.in_time.shape[1] * block.in_space.shape[1] for block in runs)
    return sum(each.values()), count, each


def error_columns(
    runs: list[Block], objective: Objective, apart: Apart, count: int, share: float = DEFECT_LEFT
) -> Float[np.ndarray, "values runs"]:
    """A column for each run: the `share` that may be left of its errors [K], whitened [1].

    `count`: of all values in the residual, those of priors among them.
    """
    white = np.asarray(whitened(objective, apart))
    made = np.zeros((count, len(runs)))
    for number, block in enumerate(runs):
        made[block.part, number] = share * white[block.part]
    return made


def stamp_columns(
    runs: list[Block],
    objective: Objective,
    read: Sequence[Float[Array, "runs frames samples"]],
    count: int,
) -> Float[np.ndarray, "values runs"]:
    """A column for each run: what it would read were its stamps off by `STAMP`, whitened [1].

    As a clock that is off reads it, or just after a switch the difference between two accounts of
    the same would tell such a clock far better than stamps are known.

    Arguments: `read`: what is read at the standing [K]; `count` as in `error_columns`.
    """
    slopes = []
    for case, group in zip(objective.cases, read, strict=True):
        rows = []
        for when, one in zip(np.asarray(case.time), np.asarray(group), strict=True):
            own = slice(_own_frames(when))
            apart = np.zeros_like(one)
            apart[own] = _rates(one, when)[own]
            rows.append(STAMP * np.median(np.diff(when[own])) * apart)
        slopes.append(jnp.asarray(np.stack(rows)))
    white = np.asarray(whitened(objective, slopes))
    made = np.zeros((count, len(runs)))
    for number, block in enumerate(runs):
        made[block.part, number] = white[block.part]
    return made


def _rates(
    read: Float[np.ndarray, "frames samples"], when: Float[np.ndarray, " frames"]
) -> Float[np.ndarray, "frames samples"]:
    """How fast what is read changes from where each frame is [K/s]; its times [s]."""
    return np.asarray(_going(jnp.asarray(read), jnp.asarray(when)))


@program
def _going(
    values: Float[Array, "frames samples"], time: Float[Array, " frames"]
) -> Float[Array, "frames samples"]:
    def later(by: Float[Array, ""]) -> Float[Array, "frames samples"]:
        return between_frames(values, time, time + by)

    return jax.jvp(later, (jnp.zeros(()),), (jnp.ones(()),))[1]

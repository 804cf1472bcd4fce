"""A run made ready for a fit: conditions, steps, read-out, data and weights; several stacked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeVar, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from thermo.inverse._common_errors import CommonErrors
from thermo.inverse._conditions import Conditions, conditions
from thermo.inverse._reading_errors import ReadingErrors, in_common
from thermo.observe import Noise, Run, bind
from thermo.physics import Discretisation, ReadOut, TimeGrid, between_steps, lengthened

Part = TypeVar("Part")

# Quiet frames whose mean is so near the temperature at the start are where that is from [K]: single
# precision is no worse. By chance it is seldom so, and then they are left out, no more.
_SAME: Final = 2e-5


@final
class Case(eqx.Module):
    """One run, or several of the same shape stacked along a leading axis.

    - `grid`: steps and frames [s]; `readout`: where the samples are.
    - `time`: (frames,) [s]; `data`: (frames, samples) [K].
    - `used`: 1 where there is a valid value, else 0 [1].
    - `errors`: of the readings; `trust`: what whitened residuals are multiplied by [1].
    - `pinned`: 1 where a sample's constant error was taken off by its quiet frames, else 0 [1].
    - `defect`: what is added to the simulation for its cells and steps, (frames, samples) [K],
      before effects on the readings; `remainder`: what is added to the readings after that, if any.
    - `resting`: what those samples read wrongly before the run that are pinned, their mean [K]; NaN
      where the run is said to start at just what its quiet frames read.
    - `shared`: what they may still make wrong in all readings at once, whitened, (frames, samples)
      [1]; zero where nothing is added.
    - `between`: where frames lie between the steps, the weights of what the grid's own frames
      read, (frames, ends) [1]; None where the grid's frames are those of the data.
    """

    under: Conditions
    grid: TimeGrid
    readout: ReadOut
    time: Float[Array, "*runs frames"]
    data: Float[Array, "*runs frames samples"]
    used: Float[Array, "*runs frames samples"]
    errors: ReadingErrors
    trust: Float[Array, "*runs"]
    pinned: Float[Array, "*runs samples"]
    defect: Float[Array, "*runs frames samples"]
    shared: Float[Array, "*runs frames samples"]
    resting: Float[Array, "*runs"]
    between: Float[Array, "*runs frames ends"] | None = None
    remainder: Float[Array, "*runs frames samples"] | None = None

    def weight(self) -> Float[Array, "*runs frames samples"]:
        """1 / standard deviation of each reading, zero where there is none [1/K]."""
        return self.trust[..., None, None] * self.used / jnp.sqrt(self.errors.variance())


def constant_error(
    run: Run, noise: Noise
) -> tuple[Float[np.ndarray, " samples"], Float[np.ndarray, " samples"]]:
    """Constant error [K] of each sample, from its quiet frames, and the variance of that [K2].

    Without quiet frames it is not known, and its variance is what the run states, or what the noise
    has of it where that is more.
    """
    quiet, samples = run.recording.quiet, len(run.recording.points)
    if quiet is None or not run.recording.knows_quiet():
        return np.zeros(samples), np.full(samples, max(run.constant_error, noise.offset) ** 2)
    known = np.isfinite(quiet)
    count = np.maximum(known.sum(0), 1)
    error = np.where(known, quiet - run.initial_temperature, 0.0).sum(0) / count
    # A sample that is never seen quiet keeps its values, and an error as the others have it.
    return error, np.where(known.any(0), noise.mean_variance(count), noise.offset**2)


def common_deviations(run: Run, noise: Noise) -> tuple[float, float]:
    """Of what all samples of a frame have in common, and of what all readings of a run have [K].

    What quiet frames have in common is taken for a constant error, and leaves their share of it.
    """
    quiet = run.recording.quiet
    if noise.frame == 0 or quiet is None:
        return 0.0, 0.0
    return noise.frame, float(noise.frame / np.sqrt(np.isfinite(quiet).any(1).sum()))


def reading_errors(
    run: Run, noise: Noise, frames: Int[np.ndarray, " frames"], *, model_error: float
) -> ReadingErrors:
    """The errors of a run's readings at some of its frames, of a noise and of `model_error` [K]."""
    _, staying = constant_error(run, noise)
    fades = noise.correlation > 0
    own = float(model_error) ** 2 + (0.0 if fades else noise.white**2)
    alone = ReadingErrors(
        own=jnp.asarray(np.full((len(frames), len(staying)), own)),
        fading=jnp.asarray(noise.white**2 if fades else 0.0, float),
        kept=jnp.asarray(noise.correlation ** np.diff(frames, prepend=frames[0])),
        staying=jnp.asarray(staying),
    )
    frame, lasting = common_deviations(run, noise)
    if frame == 0:
        return alone
    used = jnp.asarray(run.recording.valid[frames], float)
    return in_common(alone, used, jnp.asarray(frame, float), jnp.asarray(lasting, float))


def pinned(run: Run) -> Float[np.ndarray, " samples"]:
    """1 where `constant_error` takes a sample's constant error off, else 0 [1]."""
    quiet = run.recording.quiet
    if quiet is None or not run.recording.knows_quiet():
        return np.zeros(len(run.recording.points))
    return np.isfinite(quiet).any(0).astype(float)


def _resting(run: Run, error: Float[np.ndarray, " samples"]) -> float:
    """What samples read wrongly before a run, the mean of those `pinned` [K], as `Case` has it."""
    known, quiet = pinned(run), run.recording.quiet
    if quiet is None or not known.any():
        return float("nan")
    # A start that was read off these frames, as `thermo register` does, is no measure of them.
    taken = abs(float(np.nanmean(quiet)) - run.initial_temperature) < _SAME
    return float("nan") if taken else float(known @ error / known.sum())


def make_case(
    run: Run,
    space: Discretisation,
    grid: TimeGrid,
    *,
    steps: TimeGrid | None = None,
    model_error: float,
    where: str,
) -> Case:
    """Bind a run to a mesh and weigh its data.

    The errors of readings are a fluctuation of the recording's noise level, correlated from frame
    to frame as that is, `model_error`, and what stays of each sample's constant error. That error,
    known from its quiet frames, is taken off; what those frames leave open of it stays.

    Arguments:

    - `grid`: its frames must be frames of the recording [s].
    - `steps`: other steps to simulate by [s]; frames of `grid` are interpolated between them.
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` where samples lie away from the surface.
    """
    recording = run.recording
    readout, _ = bind(recording, space.mesh, where=where)
    frames = np.searchsorted(recording.time, np.asarray(grid.frame_time) - 1e-9)
    noise = run.noise_of_readings()
    error = constant_error(run, noise)[0]
    data = jnp.asarray(recording.temperature[frames] - error)
    errors = reading_errors(run, noise, frames, model_error=model_error)
    used = jnp.asarray(recording.valid[frames], float)
    time = jnp.asarray(grid.frame_time, float)
    read = (time, data, used, errors, jnp.asarray(1.0, float), jnp.asarray(pinned(run)))
    none = (jnp.zeros(data.shape), jnp.zeros(data.shape))
    under = conditions(run, space)
    resting = jnp.asarray(_resting(run, error))
    if steps is None:
        return Case(under, grid, readout, *read, *none, resting)
    ends = np.asarray(steps.frame_time)
    wanted = np.asarray(grid.frame_time)
    between = jnp.asarray(between_steps(ends, np.eye(len(ends)), wanted, run.switches()))
    return Case(under, steps, readout, *read, *none, resting, between)


def in_kelvin(case: Case) -> Case:
    """The case with errors of 1 K, each by itself, so that its residual is in kelvin [K]."""
    plain = jax.tree.map(jnp.zeros_like, replace(case.errors, common=None))
    plain = replace(plain, own=jnp.ones_like(case.errors.own))
    shared = jnp.zeros_like(case.shared)
    return replace(case, errors=plain, trust=jnp.ones_like(case.trust), shared=shared)


def _pad(array: np.ndarray | Array, length: int, axis: int, *, edge: bool) -> np.ndarray:
    array = np.asarray(array)
    width = [(0, 0)] * array.ndim
    width[axis] = (0, length - array.shape[axis])
    return np.pad(array, width, mode="edge" if edge else "constant")


def pad_errors(errors: ReadingErrors, frames: int, samples: int) -> ReadingErrors:
    """Errors [K2] of so many frames and samples [1], as those there are at the end."""
    return ReadingErrors(
        own=jnp.asarray(_pad(_pad(errors.own, frames, 0, edge=True), samples, 1, edge=True)),
        fading=errors.fading,
        kept=jnp.asarray(_pad(errors.kept, frames, 0, edge=False)),
        staying=jnp.asarray(_pad(errors.staying, samples, 0, edge=True)),
        common=None if errors.common is None else _pad_common(errors.common, frames),
    )


def _pad_common(common: CommonErrors, frames: int) -> CommonErrors:
    ways = frames + 1
    turn = _pad(_pad(common.turn, ways, 0, edge=False), ways, 1, edge=False)
    size = _pad(common.size, ways, 0, edge=False)
    return replace(common, turn=jnp.asarray(turn), size=jnp.asarray(size))


def _pad_case(case: Case, steps: int, ends: int, frames: int, samples: int) -> Case:
    """Lengthen a case by steps of no duration and by data of no weight."""
    grid = lengthened(case.grid, steps, ends)
    readout = ReadOut(
        _pad(case.readout.nodes, samples, 0, edge=True),
        _pad(case.readout.weights, samples, 0, edge=True),
    )
    data = _pad(_pad(case.data, frames, 0, edge=True), samples, 1, edge=True)
    used, defect, shared = (
        jnp.asarray(_pad(_pad(values, frames, 0, edge=False), samples, 1, edge=False))
        for values in (case.used, case.defect, case.shared)
    )
    held = jnp.asarray(_pad(case.pinned, samples, 0, edge=True))
    errors = pad_errors(case.errors, frames, samples)
    between = case.between
    if between is not None:
        between = jnp.asarray(_pad(_pad(between, frames, 0, edge=False), ends, 1, edge=False))
    time = jnp.asarray(_pad(case.time, frames, 0, edge=True))
    read = (time, jnp.asarray(data), used, errors, case.trust, held, defect, shared)
    return Case(case.under, grid, readout, *read, case.resting, between)


def group_cases(cases: Sequence[Case]) -> list[list[int]]:
    """Numbers [1] of the runs that have the same effects and kinds of errors, group by group."""
    groups: dict[str, list[int]] = {}
    for number, case in enumerate(cases):
        shape = str(jax.tree.structure((case.under, case.errors))) + str(
            [np.shape(leaf) for leaf in jax.tree.leaves(case.under)]
        )
        groups.setdefault(shape, []).append(number)
    return list(groups.values())


def stack_cases(cases: Sequence[Case]) -> tuple[Case, ...]:
    """Stack the runs of each group, so that one program serves all of them [1]."""
    stacked = []
    for numbers in group_cases(cases):
        group = [cases[number] for number in numbers]
        steps = max(len(case.grid.start) for case in group)
        frames, samples = (max(case.data.shape[axis] for case in group) for axis in (0, 1))
        ends = max(len(case.grid.frame_step) for case in group)
        padded = [_pad_case(case, steps, ends, frames, samples) for case in group]
        stacked.append(pile(padded))
    return tuple(stacked)


def pile(parts: Sequence[Part]) -> Part:
    """Parts of runs of one shape along a leading axis, as they are.

    By NumPy, as in `one_run`: JAX would compile a program for each shape of an array.
    """
    return jax.device_put(
        jax.tree.map(lambda *leaves: np.stack([np.asarray(one) for one in leaves]), *parts)
    )


def one_run(piled: Part, row: int) -> Part:
    """What belongs to the run in row `row` [1], as it is."""
    return jax.device_put(jax.tree.map(lambda leaf: np.asarray(leaf)[row], piled))

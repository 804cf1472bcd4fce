"""Where a residual lies: a sum of squares by run, in smooth shapes and beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import chi2

from thermo.discover._softening import Block


@final
@dataclass(frozen=True)
class Part:
    """A sum of squares [1] and what noise alone leaves on average, the number of values [1]."""

    squares: float
    expected: int


@final
@dataclass(frozen=True)
class Misfit:
    """The whitened residual of a run, split so that its parts add up to the whole.

    - `steady`: smooth over the body and the same in all frames; `changing`: smooth over the body
      and in time; `rest`: all else.
    """

    steady: Part
    changing: Part
    rest: Part


def misfits(runs: list[Block], residual: Float[np.ndarray, " values"]) -> dict[str, Misfit]:
    """The misfit of each run, by its name, of a residual in what is allowed for [1]."""
    return {block.name: _misfit(block, residual) for block in runs}


def _misfit(block: Block, residual: Float[np.ndarray, " values"]) -> Misfit:
    smooth = block.coefficients(residual) ** 2
    own = residual[block.part]
    # The first shape in time is constant.
    steady, changing = float(smooth[0].sum()), float(smooth[1:].sum())
    return Misfit(
        Part(steady, smooth[0].size),
        Part(changing, smooth[1:].size),
        Part(float(own @ own) - steady - changing, block.readings - smooth.size),
    )


def chance_near(
    runs: list[Block],
    residual: Float[np.ndarray, " values"],
    near: Mapping[str, Bool[np.ndarray, " samples"]],
) -> float:
    """Probability of as large a misfit at some samples by chance, noise as large as may be [1].

    Each sample by itself, smooth in time: what a small place leaves about its edge is narrower than
    the smooth shapes over the body.

    Arguments: `residual`: in what is allowed for [1]; `near`: the samples of each run, by its name.
    """
    told, count = 0.0, 0
    for block in runs:
        own = residual[block.part].reshape(block.shape)[:, : len(near[block.name])]
        along = block.in_time.T @ own[:, near[block.name]]
        told += float(np.sum(along**2)) / block.level
        count += along.size
    return float(chi2.sf(told, count)) if count else 1.0

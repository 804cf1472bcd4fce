"""Where a residual lies: a sum of squares by run, in smooth shapes and beside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float

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

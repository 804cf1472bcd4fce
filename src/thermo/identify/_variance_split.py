"""How much of the scatter of repeated fits comes from where they began."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError


@final
@dataclass(frozen=True)
class VarianceSplit:
    """Variances of a balanced design, in the square of the values' unit.

    - `within`: between fits from the same start, which differ in their seeds.
    - `across`: between starts, without what seeds alone make of their means; never negative.
    - `across_raw`: the same with it, the variance of the means of the starts.
    """

    within: float
    across: float
    across_raw: float

    def share(self) -> float:
        """Part of the variance of one fit that comes from its start [1]; 0 where none varies."""
        total = self.within + self.across
        return self.across / total if total > 0 else 0.0


def split_variance(values: Float[np.ndarray, "starts seeds"]) -> VarianceSplit:
    """One-way analysis of variance of fits from several starts, each with several seeds.

    With n seeds, MS_across = n var(means of the starts), MS_within = mean of the variances within:

        within = MS_within,   across = max(0, (MS_across - MS_within) / n)

    Arguments: `values`: in any unit, such as logarithms of medians [1].

    Raises `InputError` where there are fewer than two starts or seeds, or a value is not finite.

    Source: Searle, Casella, McCulloch, Variance Components (1992), section 3.5.
    """
    values = np.asarray(values, float)
    starts, seeds = values.shape if values.ndim == 2 else (0, 0)
    if starts < 2 or seeds < 2 or not np.isfinite(values).all():
        raise InputError(
            "repeated fits cannot be split into parts",
            where="values",
            value=f"{starts} starts, {seeds} seeds, {int(np.isfinite(values).sum())} finite",
            limit="two starts and two seeds at least, a finite value for each pair",
            remedy="repeat the fits that are missing",
        )
    within = float(values.var(axis=1, ddof=1).mean())
    raw = float(values.mean(axis=1).var(ddof=1))
    return VarianceSplit(within, max(0.0, raw - within / seeds), raw)

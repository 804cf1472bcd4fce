"""What the scale of the surface does to the values of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np


@final
@dataclass(frozen=True)
class ScaleEffect:
    """What the scale of the surface does to the values of a fit, to first order.

    - `deviation`: standard deviation of the logarithm of the scale [1].
    - `change`: by quantity, change of the mean of log(value) over the surface per unit of the
      logarithm of the scale [1]: 2 for a conductivity that only time tells.
    - `without`: by quantity, standard deviation of that mean were the scale known [1].
    """

    deviation: float
    change: dict[str, float]
    without: dict[str, float]

    def part(self, name: str) -> float:
        """Standard deviation of log(value) that comes from the scale [1]."""
        return abs(self.change[name]) * self.deviation

    def total(self, name: str) -> float:
        """Standard deviation of log(value) with the scale [1]."""
        return float(np.hypot(self.without[name], self.part(name)))

    def share(self, name: str) -> float:
        """Share of the variance of log(value) that comes from the scale [1]."""
        return (self.part(name) / self.total(name)) ** 2 if self.part(name) else 0.0


def scale_remarks(effect: ScaleEffect | None) -> list[str]:
    """What the scale of the surface leaves open of each value, in words."""
    if effect is None:
        return []
    return [
        f"The surface's scale is known to {100 * effect.deviation:.2g} %, and {name} follows it "
        f"{effect.change[name]:+.3g} times: a standard deviation of {100 * effect.part(name):.2g} "
        f"% beside {100 * effect.without[name]:.2g} % from the readings, "
        f"{100 * effect.share(name):.3g} % of the variance."
        for name in effect.change
    ]

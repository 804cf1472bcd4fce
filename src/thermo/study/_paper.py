"""The rows of the paper's tables, with its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, final

BOTH: Final = ("cooling", "heating")
JOINT: Final = "joint"
"""A process that fits the runs of `BOTH` at once."""

HELD_OUT: Final = MappingProxyType({"warming": "test_warming", "heating": "test_heating"})
"""Runs that are predicted, by what the paper's table 2 calls them."""


@final
@dataclass(frozen=True)
class Row:
    """A scene of the paper's table 1 and what it is to tell.

    - `object`, `process`: the folder of the scene and its run.
    - `quantity`: what is recovered; `known`: values that are held at the truth [SI].
    - `start`: factor on the first value of the unknown [1]: a scene that states the answer must
      not begin with it.
    - `error`, `ratio`, `width`: the paper's [1].
    - `warming`, `heating`: the paper's mean absolute error of the spatial field and of its median
      under held-out conditions [K], None where its table 2 has no such row.
    """

    object: str
    process: str
    quantity: str
    error: float
    ratio: float
    width: float
    warming: tuple[float, float] | None = None
    heating: tuple[float, float] | None = None
    known: dict[str, float] = field(default_factory=dict)
    start: float = 1.0

    def name(self) -> str:
        """Object and process, as in `cube-cooling`."""
        return f"{self.object}-{self.process}"

    def runs(self) -> tuple[str, ...]:
        """Names of the runs that are fitted."""
        return BOTH if self.process == JOINT else (self.process,)


_ALPHA: Final = "diffusivity"

# The paper holds the diffusivity of the cylinder at the truth (table A1) where it recovers beta.
_STEEL: Final = {"conductivity": 15.1}

TABLE_ONE: Final = (
    Row("cube", "cooling", _ALPHA, 0.225, 0.778, 0.331, (0.077, 0.096), (0.665, 0.875)),
    Row("cube", "heating", _ALPHA, 0.204, 0.842, 0.656, (0.134, 0.095), (0.297, 0.453)),
    Row("sphere", "cooling", _ALPHA, 0.428, 0.573, 0.083),
    Row("sphere", "heating", _ALPHA, 0.140, 0.953, 0.557),
    Row("cylinder", "cooling", "scaled_convection", 0.110, 1.056, 0.428,
        (0.038, 11.446), (45.039, 36.342), known=_STEEL, start=3.0),
    Row("cylinder", "heating", _ALPHA, 0.145, 1.015, 0.631, (0.054, 0.116), (0.516, 2.588)),
    Row("bunny", "cooling", _ALPHA, 0.207, 0.984, 1.125),
    Row("bunny", "heating", _ALPHA, 0.426, 1.147, 0.989),
    Row("bear", "cooling", _ALPHA, 0.119, 1.008, 0.544, (0.196, 0.245), (0.386, 0.397)),
    Row("bear", "heating", _ALPHA, 0.831, 1.153, 3.078, (0.784, 0.805), (0.306, 0.315)),
    Row("car", "cooling", _ALPHA, 0.242, 0.889, 0.849, (0.485, 0.523), (2.186, 0.861)),
    Row("car", "heating", _ALPHA, 0.147, 0.938, 0.548, (0.485, 0.522), (1.505, 0.050)),
)  # fmt: skip
"""Table 1 of the paper, with the mean absolute errors of its table 2."""

ROWS: Final = MappingProxyType({row.name(): row for row in TABLE_ONE})
"""The rows by name."""

QUICK_ROWS: Final = ("cube-heating", "cylinder-cooling")
"""What a quick study looks at."""

REPEATED: Final = MappingProxyType({
    "bunny-cooling": (1.147, 1.337, 0.227),
    "car-cooling": (0.791, 0.803, 0.0047),
    "car-heating": (0.949, 0.739, 0.0105),
    "sphere-heating": (0.963, 0.655, 0.0731),
    "bear-cooling": (1.107, 1.182, 0.0783),
})  # fmt: skip
"""Figure 3 of the paper: medians over 16 fits of ratio [1], width [1] and final error [K]."""


def joint_row(row: Row) -> Row | None:
    """The row that fits cooling and heating of an object at once.

    None where the two do not share an unknown.
    """
    names = [f"{row.object}-{process}" for process in BOTH]
    if any(name not in ROWS or ROWS[name].quantity != row.quantity for name in names):
        return None
    nan = float("nan")
    return replace(row, process=JOINT, error=nan, ratio=nan, width=nan, warming=None, heating=None)

"""Wanted cell sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

from ._surface import Surface

TOLERANCE: Final = 5e-4
"""How far the mesh may lie off the surface where nothing is stated, over the box diagonal."""


@final
@dataclass(frozen=True, eq=False)
class Fine:
    """Where cells are to be small: edges of at most `edge` [m] at `points` (points, 3) [m].

    Away from there they grow by half of the distance. Raises `InputError` where `edge` is not
    positive or there is no point.
    """

    points: Float[np.ndarray, "points 3"]
    edge: float

    def __post_init__(self) -> None:
        """Refuse an edge that is no length, and points that are none."""
        if not (np.isfinite(self.edge) and self.edge > 0.0 and len(self.points)):
            raise InputError(
                "there is nowhere to be fine",
                where="sizing.fine",
                value=f"edge {self.edge:g} m at {len(self.points)} points",
                limit="an edge above 0 m at one point or more",
                remedy="state the edge in metres, or leave `fine` out",
            )


@final
@dataclass(frozen=True)
class Sizing:
    """Wanted edge lengths of a graded mesh.

    Arguments:
    - `skin`: edge length at the surface [m].
    - `core`: edge length deep inside [m], not below `skin`.
    - `depth`: thickness of the layer over which the length grows from skin to core [m].
    - `tolerance`: how far the mesh may lie off the surface [m]; 5e-4 box diagonals where None.
    - `fine`: where edges are shorter than that; no count of nodes expects them.
    """

    skin: float | int
    core: float | int
    depth: float | int
    tolerance: float | int | None = None
    fine: tuple[Fine, ...] = ()

    def __post_init__(self) -> None:
        """Refuse lengths that are not positive or a core finer than the skin."""
        for name in ("skin", "core", "depth", "tolerance"):
            value = getattr(self, name)
            if name == "tolerance" and value is None:
                continue
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(
                    "a length is not positive",
                    where=f"sizing.{name}",
                    value=value,
                    limit="a finite length above 0 m",
                    remedy="state the length in metres",
                )
        if self.core < self.skin:
            raise InputError(
                "the inside is finer than the skin",
                where="sizing.core",
                value=f"{self.core:g} m",
                limit=f"skin = {self.skin:g} m or more",
                remedy="make core as long as skin or longer",
            )

    def envelope(self, surface: Surface) -> float:
        """How far the mesh may lie off `surface` [m]."""
        return TOLERANCE * surface.diagonal() if self.tolerance is None else float(self.tolerance)

    def divided(self, by: float | int) -> Sizing:
        """All edges [m] divided by a number [1], and a tolerance that is stated."""
        tolerance = None if self.tolerance is None else self.tolerance / by
        fine = tuple(Fine(one.points, one.edge / by) for one in self.fine)
        return Sizing(self.skin / by, self.core / by, self.depth, tolerance, fine)


def heat_depth(diffusivity: float | int, duration: float | int) -> float:
    """Depth sqrt(diffusivity duration) [m] that heat reaches in `duration` [s].

    Arguments: `diffusivity` [m2/s], `duration` [s]. Raises `InputError` unless both are positive.
    """
    for name, value, unit in (("diffusivity", diffusivity, "m2/s"), ("duration", duration, "s")):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(
                f"the {name} is not positive",
                where=name,
                value=value,
                limit=f"a finite number above 0 {unit}",
                remedy=f"state the {name} in {unit}",
            )
    return float(np.sqrt(diffusivity * duration))

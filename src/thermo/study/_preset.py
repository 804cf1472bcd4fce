"""Complete settings of a fit, the same for every scene."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, final

from thermo.inverse import (
    AbstractFieldChoice,
    AbstractOptimiser,
    Adam,
    LevenbergMarquardt,
    Meshing,
    Network,
    OnControlPoints,
    Prior,
    Stepping,
    Uniform,
)
from thermo.physics.integrators import BackwardEuler


@final
@dataclass(frozen=True)
class Preset:
    """Everything that `thermo.invert` can be told about how to fit [SI units as there].

    Without an `optimiser` nothing is fitted: what the prior expects is the answer.
    """

    choice: AbstractFieldChoice = field(default_factory=OnControlPoints)
    optimiser: AbstractOptimiser | None = field(default_factory=LevenbergMarquardt)
    prior: Prior = field(default_factory=Prior)
    stepping: Stepping = field(default_factory=Stepping)
    meshing: Meshing = field(default_factory=Meshing)


# What the paper does not state (sizes of network and meshes, rates, epochs, weights) is chosen
# once, for all scenes; conf/preset/paper.yaml says the same to the command.
_PAPER: Final = Preset(
    choice=Network(linear=True),
    optimiser=Adam(max_steps=100, rate=0.01),
    prior=Prior(step=0.3, decay=1e-3),
    stepping=Stepping(integrator=BackwardEuler(), size=0.1, lagged=True),
    meshing=Meshing(max_nodes=6000),
)

PRESETS: Final = MappingProxyType({
    "best": Preset(),
    "uniform": Preset(choice=Uniform()),
    "prior": Preset(choice=Uniform(), optimiser=None),
    "paper": _PAPER,
})  # fmt: skip
"""Ours, the same with one value for the body, the value that the prior expects, the paper's."""

"""The heat equation on tetrahedra: operators, effects, integrators, simulation."""

from thermo.physics._adjoint import AbstractAdjoint, RecomputeSegments, StoreSteps
from thermo.physics._balance import Balance, assemble, heat_rate, step_matrix, stored_heat
from thermo.physics._between_steps import between_steps
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._discretisation import Discretisation, discretise
from thermo.physics._forward_only import ForwardOnly
from thermo.physics._model import Model
from thermo.physics._quadrature import triangle_rule
from thermo.physics._readout import ReadOut, every_node
from thermo.physics._simulate import Solution, solve_heat
from thermo.physics._step_matrix import StepMatrix
from thermo.physics._time_grid import (
    TimeGrid,
    every_step,
    lengthened,
    plan_steps,
    rounded_up,
    uniform_steps,
)
from thermo.physics._volume_rule import VolumeRule, volume_rule

__all__ = [
    "AbstractAdjoint",
    "Balance",
    "ConjugateGradient",
    "Discretisation",
    "ForwardOnly",
    "Model",
    "ReadOut",
    "RecomputeSegments",
    "Solution",
    "StepMatrix",
    "StoreSteps",
    "TimeGrid",
    "VolumeRule",
    "assemble",
    "between_steps",
    "discretise",
    "every_node",
    "every_step",
    "heat_rate",
    "lengthened",
    "plan_steps",
    "rounded_up",
    "solve_heat",
    "step_matrix",
    "stored_heat",
    "triangle_rule",
    "uniform_steps",
    "volume_rule",
]

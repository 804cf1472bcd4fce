"""Time integrators, one scheme a file."""

from thermo.physics.integrators._backward_euler import BackwardEuler
from thermo.physics.integrators._integrator import AbstractIntegrator
from thermo.physics.integrators._sdirk2 import Sdirk2, step_with_error

__all__ = ["AbstractIntegrator", "BackwardEuler", "Sdirk2", "step_with_error"]

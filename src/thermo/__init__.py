"""ThermoField: what an object is made of, thermally, from watching its surface temperature."""

from thermo._conflict import refuse_conflict

refuse_conflict()

import jax  # noqa: E402

# Kelvin to a thousandth over hundreds of steps needs double precision.
jax.config.update("jax_enable_x64", True)

from thermo._compiled import keep_compiled  # noqa: E402

keep_compiled()

from thermo.errors import InputError  # noqa: E402
from thermo.inverse import Estimate, Prediction, invert, predict, simulate  # noqa: E402
from thermo.observe import Scene, read_scene  # noqa: E402

__all__ = [
    "Estimate",
    "InputError",
    "Prediction",
    "Scene",
    "invert",
    "predict",
    "read_scene",
    "simulate",
]

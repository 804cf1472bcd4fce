"""Effects: what exchanges, heats or holds the body. One final module each."""

from thermo.physics.effects._convection import Contact, Convection
from thermo.physics.effects._effect import AbstractSurfaceEffect, AbstractVolumeEffect
from thermo.physics.effects._gap import GapExchange, gap_exchange
from thermo.physics.effects._heating import (
    Heating,
    NodalSource,
    PrescribedFlux,
    VolumetricSource,
    patch_profile,
    spot_profile,
)
from thermo.physics.effects._law import (
    AbstractLaw,
    PolynomialLaw,
    SumLaw,
    TabulatedLaw,
    TransitionLaw,
)
from thermo.physics.effects._prescribed import PrescribedTemperature
from thermo.physics.effects._radiation import STEFAN_BOLTZMANN, LaggedRadiation, Radiation
from thermo.physics.effects._schedule import History, Schedule, value_at

__all__ = [
    "STEFAN_BOLTZMANN",
    "AbstractLaw",
    "AbstractSurfaceEffect",
    "AbstractVolumeEffect",
    "Contact",
    "Convection",
    "GapExchange",
    "Heating",
    "History",
    "LaggedRadiation",
    "NodalSource",
    "PolynomialLaw",
    "PrescribedFlux",
    "PrescribedTemperature",
    "Radiation",
    "Schedule",
    "SumLaw",
    "TabulatedLaw",
    "TransitionLaw",
    "VolumetricSource",
    "gap_exchange",
    "patch_profile",
    "spot_profile",
    "value_at",
]

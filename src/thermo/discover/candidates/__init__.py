"""Effects that may be missing, each one module whose strength of zero means that it is absent."""

from thermo.discover.candidates._camera import CameraDrift, CameraEmissivity, ClockOffset, SensorLag
from thermo.discover.candidates._heating import (
    HeaterLag,
    HeaterPower,
    HiddenSource,
    InDepthAbsorption,
)
from thermo.discover.candidates._material import (
    AnisotropicConductivity,
    LatentHeat,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
    Void,
)
from thermo.discover.candidates._surroundings import (
    AmbientDrift,
    BackingConduction,
    Evaporation,
    LocalConvection,
    MissingRadiation,
    SupportContact,
)

__all__ = [
    "AmbientDrift",
    "AnisotropicConductivity",
    "BackingConduction",
    "CameraDrift",
    "CameraEmissivity",
    "ClockOffset",
    "Evaporation",
    "HeaterLag",
    "HeaterPower",
    "HiddenSource",
    "InDepthAbsorption",
    "LatentHeat",
    "LocalConvection",
    "MissingRadiation",
    "SensorLag",
    "SupportContact",
    "TemperatureDependentConductivity",
    "TemperatureDependentHeatCapacity",
    "Void",
]

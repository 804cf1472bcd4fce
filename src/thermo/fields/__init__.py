"""Thermophysical fields on the object, from few unconstrained parameters."""

from thermo.fields._direct import (
    DirectField,
    control_point_field,
    patchwise_field,
    uniform_field,
)
from thermo.fields._extension import Extension
from thermo.fields._field import AbstractField, cell_values, face_values
from thermo.fields._frozen import FrozenField, freeze
from thermo.fields._head import AbstractHead, LinearHead, LogHead
from thermo.fields._network import NetworkField, encode, network_field
from thermo.fields._quantity import QUANTITIES, Quantity
from thermo.fields._surface_graph import ControlPoints, place_control_points, surface_vertices

__all__ = [
    "QUANTITIES",
    "AbstractField",
    "AbstractHead",
    "ControlPoints",
    "DirectField",
    "Extension",
    "FrozenField",
    "LinearHead",
    "LogHead",
    "NetworkField",
    "Quantity",
    "cell_values",
    "control_point_field",
    "encode",
    "face_values",
    "freeze",
    "network_field",
    "patchwise_field",
    "place_control_points",
    "surface_vertices",
    "uniform_field",
]

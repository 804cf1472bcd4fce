"""Thermophysical fields on the object, from few unconstrained parameters."""

from thermo.fields._departure import DepartingField, departing_field
from thermo.fields._direct import (
    DirectField,
    control_point_field,
    patchwise_field,
    uniform_field,
)
from thermo.fields._extension import Extension
from thermo.fields._field import AbstractExtendedField, AbstractField
from thermo.fields._frozen import FrozenField, freeze
from thermo.fields._head import AbstractHead, LinearHead, LogHead
from thermo.fields._network import NetworkField, encode, network_field
from thermo.fields._quantity import QUANTITIES, Quantity
from thermo.fields._surface_graph import ControlPoints, place_control_points, surface_vertices
from thermo.fields._two_materials import (
    Boundary,
    TwoMaterialField,
    two_material_field,
    two_material_values,
)

__all__ = [
    "QUANTITIES",
    "AbstractExtendedField",
    "AbstractField",
    "AbstractHead",
    "Boundary",
    "ControlPoints",
    "DepartingField",
    "DirectField",
    "Extension",
    "FrozenField",
    "LinearHead",
    "LogHead",
    "NetworkField",
    "Quantity",
    "TwoMaterialField",
    "control_point_field",
    "departing_field",
    "encode",
    "freeze",
    "network_field",
    "patchwise_field",
    "place_control_points",
    "surface_vertices",
    "two_material_field",
    "two_material_values",
    "uniform_field",
]

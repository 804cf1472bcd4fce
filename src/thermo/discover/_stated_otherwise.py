"""Whether a scene states what was taken to be true when an estimate was made."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import equinox as eqx
import numpy as np

from thermo.inverse import law_of, load_estimate
from thermo.observe import Scene, read_scene

# Values of which a fit may have found another one: then what is stated takes no part.
_FOUND_AS: Final = {
    "conductivity": ("conductivity", "diffusivity"),
    "volumetric_heat_capacity": ("volumetric_heat_capacity",),
    "convection": ("convection", "scaled_convection"),
    "emissivity": ("emissivity", "scaled_emissivity"),
}
_UNITS: Final = {
    "conductivity": "W/m/K", "volumetric_heat_capacity": "J/m3/K", "convection": "W/m2/K",
    "emissivity": "",
}  # fmt: skip
_SAME: Final = 1e-6


def stated_otherwise(folder: str | Path, data: Scene | str | Path) -> list[str]:
    """In words which values an estimate took to be true that a scene states otherwise.

    A prediction takes those of the estimate, and the effects that were found hold beside them.

    Arguments: `folder`: that `thermo discover` or `thermo invert` left; `data`: a scene, or its
    folder.

    Raises `InputError` where the estimate or the scene cannot be read.
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    _, _, stated, fields = load_estimate(Path(folder) / "estimate.npz")
    material = scene.material
    here = {
        "conductivity": material.first_conductivity(),
        "volumetric_heat_capacity": material.volumetric_heat_capacity(),
        "convection": scene.convection,
        "emissivity": scene.emissivity,
    }
    told = [
        f"The estimate was made with {name} {stated.of(name):.6g} {_UNITS[name]}".rstrip()
        + f", this scene states {value:.6g}: the former is taken."
        for name, value in here.items()
        if value is not None
        and not set(_FOUND_AS[name]) & set(fields)
        and not np.isclose(stated.of(name), value, rtol=_SAME, atol=0.0)
    ]
    courses = (
        ("conductivity", stated.conductivity_law, material.conductivity),
        ("heat capacity", stated.capacity_law, material.heat_capacity),
    )
    return told + [
        f"The estimate was made with another course of the {name} over temperature than this "
        "scene states: the former is taken. Fit anew where the scene is right."
        for name, law, value in courses
        if not eqx.tree_equal(law, law_of(value), rtol=_SAME)
    ]

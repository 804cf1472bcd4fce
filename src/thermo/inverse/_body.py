"""The object made ready: its mesh, and the values that stand in for what is not known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, final

import numpy as np

from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._lamp_spots import lamp_spots
from thermo.inverse._properties import Stated, law_of, properties
from thermo.inverse._side_by_side import solve_each
from thermo.inverse._stated_places import check_places
from thermo.mesh import (
    Fine,
    Mesh,
    Sizing,
    Surface,
    expected_nodes,
    promote,
    read_surface,
    sizing_from_physics,
    tetrahedralise,
)
from thermo.observe import Run, Scene, bind
from thermo.physics import discretise, uniform_steps

# Standing in for a conductivity that nothing is known of: from foam to silver [W/m/K].
SCANNED_CONDUCTIVITIES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
SCAN_NODES = 1500
SCAN_LOOSE = 0.05
"""How far the scan's mesh may lie off the surface, over its edges and over how thick it is [1]."""


@final
@dataclass(frozen=True)
class Meshing:
    """How the body is meshed.

    - `order`: 1 for TET4, 2 for TET10.
    - `max_nodes`: about the most nodes of the TET10 mesh [1].
    - `coarse_tangents`: take the dense Jacobian of Levenberg-Marquardt from linear cells and half
      as many steps. It is cheaper and steers a fit whose residual stays that of `order`; None
      takes it above eight unknowns.
    - `corrected`: measure on a mesh twice as fine what cells and steps make wrong where a fit
      stands, take it off and go on; where the data choose how smooth a field is, before they do.
      Not with optimisers of fixed length.
    - `cells_per_depth`: cells over the depth that heat reaches [1].
    - `cache`: folder of meshes, None for the user's cache.
    """

    order: Literal[1, 2] = 2
    max_nodes: int = 15000
    coarse_tangents: bool | None = None
    corrected: bool = True
    cells_per_depth: float = 1.0
    cache: Path | None = None


def duration(scene: Scene) -> float:
    """Time [s] of the scene's longest run."""
    return max(float(run.recording.time[-1]) for run in scene.runs.values())


def sizing_of(scene: Scene, surface: Surface, diffusivity: float, meshing: Meshing) -> Sizing:
    """Edges [m] that suit a diffusivity [m2/s], the scene's longest run and its lamps."""
    sizing = sizing_from_physics(
        surface,
        diffusivity=diffusivity,
        duration=duration(scene),
        cells_per_depth=meshing.cells_per_depth,
        max_nodes=meshing.max_nodes,
    )
    return replace(sizing, fine=lamp_spots(scene, surface, sizing, meshing.max_nodes))


def make_mesh(
    scene: Scene,
    surface: Surface,
    diffusivity: float,
    meshing: Meshing,
    *,
    finer: float = 1.0,
    fine: tuple[Fine, ...] = (),
) -> Mesh:
    """Linear mesh [m] graded for a diffusivity [m2/s], all its lengths divided by `finer` [1].

    `fine`: where they are shorter still.
    """
    sizing = sizing_of(scene, surface, diffusivity, meshing)
    if finer != 1.0:
        sizing = sizing.divided(finer)
    sizing = replace(sizing, fine=(*sizing.fine, *fine))
    return tetrahedralise(surface, sizing, cache=meshing.cache, where=str(scene.surface_path))


def of_order(mesh: Mesh, order: int) -> Mesh:
    """The linear mesh itself, or promoted to quadratic cells [1]."""
    return mesh if order == 1 else promote(mesh)


def surface_of(scene: Scene) -> Surface:
    """The scene's checked surface [m].

    Raises `InputError` as `read_surface` does, and where a box or a lamp of the scene misses it.
    """
    surface = read_surface(scene.surface_path, unit=scene.unit)  # type: ignore[arg-type]
    check_places(scene, surface)
    return surface


def state(scene: Scene, initial: dict[str, float], conductivity: float) -> Stated:
    """Uniform values [SI]: `initial`, then the scene's, then `conductivity` [W/m/K]."""
    capacity = scene.material.volumetric_heat_capacity()
    given = Stated(
        conductivity=scene.material.first_conductivity() or conductivity,
        capacity=capacity,
        convection=10.0 if scene.convection is None else scene.convection,
        emissivity=0.8 if scene.emissivity is None else scene.emissivity,
    )
    capacity = initial.get("volumetric_heat_capacity", capacity)
    conductivity = initial.get("conductivity", given.conductivity)
    if "diffusivity" in initial:
        conductivity = initial["diffusivity"] * capacity
    convection = initial.get("convection", given.convection)
    if "scaled_convection" in initial:
        convection = initial["scaled_convection"] * capacity
    emissivity = initial.get("emissivity", given.emissivity)
    if "scaled_emissivity" in initial:
        emissivity = initial["scaled_emissivity"] * capacity
    material = scene.material
    laws = law_of(material.conductivity), law_of(material.heat_capacity)
    return Stated(conductivity, capacity, convection, emissivity, *laws)


MAY_VANISH = ("convection", "emissivity", "scaled_convection", "scaled_emissivity")
"""Exchange with the surroundings may be nothing, as long as it is not what is looked for."""


def check_values(
    values: dict[str, float], unknown: tuple[str, ...] = (), where: str = "initial."
) -> None:
    """Refuse values [SI] that cannot be. Raises `InputError`.

    `unknown` names what a fit looks for on a logarithmic scale; `where` is the section's name.
    """
    wrong = [name for name in values if name not in QUANTITIES]
    if wrong:
        raise InputError(
            "there is no such quantity",
            where=f"{where}{wrong[0]}",
            value=values[wrong[0]],
            limit=", ".join(QUANTITIES),
            remedy="give values of these quantities [SI]",
        )
    for name, value in values.items():
        least = 0.0 if name in MAY_VANISH and name not in unknown else np.finfo(float).tiny
        if not (np.isfinite(value) and value >= least):
            raise InputError(
                "a value is not positive",
                where=f"{where}{name}",
                value=value,
                limit="a finite number, 0 or more" if least == 0.0 else "a finite number above 0",
                remedy="give a rough guess in SI units",
            )
        bounds = QUANTITIES[name]
        # A value that a fit left on a bound may lie beyond it by rounding.
        low, high = bounds.lower * (1 - 1e-9), bounds.upper * (1 + 1e-9)
        if name in unknown and not low <= value <= high:
            raise InputError(
                "a first value lies beyond where it is looked for",
                where=f"{where}{name}",
                value=value,
                limit=f"{bounds.lower:g} to {bounds.upper:g} {bounds.unit}",
                remedy="give a value between these; is it in SI units?",
            )


def _scan_mesh(surface: Surface, meshing: Meshing) -> Mesh:
    """Some hundred nodes [m], off the surface by more than other meshes, which are slow to make.

    One as close as those where it does not fill the surface. Raises `InputError` as they do.
    """
    coarse = surface.diagonal() / 12
    sizing = Sizing(coarse, coarse, coarse)
    shrink = (SCAN_NODES * 8 / max(expected_nodes(surface, sizing), 1)) ** (-1 / 3)
    edge = coarse * max(shrink, 1.0)
    # Volume over area is half of how thick a wall is.
    loose = SCAN_LOOSE * min(edge, 2.0 * surface.volume() / surface.area())
    close = Sizing(edge, edge, edge)
    try:
        far = replace(close, tolerance=max(loose, close.envelope(surface)))
        return tetrahedralise(surface, far, cache=meshing.cache)
    except InputError:
        return tetrahedralise(surface, close, cache=meshing.cache)


def scan_conductivity(scene: Scene, surface: Surface, runs: list[Run], meshing: Meshing) -> float:
    """Best of a few conductivities [W/m/K] on a coarse mesh, for a scene that states none.

    One value a factor three apart from foam to silver; the sum over runs of the squared misfit at
    some twenty frames decides. Good enough to choose the mesh by and to start from.
    """
    space = discretise(_scan_mesh(surface, meshing))
    misfit = np.zeros(len(SCANNED_CONDUCTIVITIES))
    for run in runs:
        frames = run.recording.time[:: max(len(run.recording.time) // 20, 1)]
        where = f"runs.{run.name}.recording"
        readout, _ = bind(run.recording, space.mesh, where=where)
        grid = uniform_steps(frames, float(frames[-1]) / 40, run.switches())
        under = conditions(run, space)
        picked = np.searchsorted(run.recording.time, frames - 1e-9)
        data, valid = run.recording.temperature[picked], run.recording.valid[picked]
        sizes = (len(space.mesh.cells), len(space.mesh.faces))
        stated = [state(scene, {"conductivity": value}, value) for value in SCANNED_CONDUCTIVITIES]
        models = [make_model(space, properties(one, {}, *sizes), under) for one in stated]
        for number, found in enumerate(solve_each(models, under, grid, readout)):
            misfit[number] += float((np.where(valid, found - data, 0.0) ** 2).sum())
    return float(SCANNED_CONDUCTIVITIES[int(np.argmin(misfit))])

"""The conditions of a run on a mesh, and the model that they make with a body's properties."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from thermo.errors import InputError
from thermo.inverse._light_path import LightPath, dark, light_path
from thermo.inverse._properties import Properties
from thermo.inverse._stated_places import SLACK, misses
from thermo.observe import Box, Heater, Run
from thermo.physics import Discretisation, Model
from thermo.physics.effects import (
    Convection,
    Heating,
    History,
    LaggedRadiation,
    PrescribedTemperature,
    Radiation,
    Schedule,
    spot_profile,
)


@final
class Conditions(eqx.Module):
    """Under what a run was taken; every run has the same structure, so that runs can be stacked.

    - `initial`, `ambient`, `surroundings`: [K].
    - `power` [W], zero without a lamp; `profile` (faces, points) [1/m2]; `schedule`.
    - `path`: of the lamp's light through the cells.
    - `exposed`: (faces,), 1 where a face exchanges with air and surroundings, 0 where it is
      insulated [1].
    - `own`: (faces,), 1 where the body's own convection holds, 0 where that of the air is known
      [1]; `known`: that one, (faces,) [W/m2/K], and `warmer`: how much warmer than `ambient` that
      air is, (faces,) [K].
    - `prescribed`: nodes with given temperatures, or None.
    """

    initial: Float[Array, ""]
    ambient: Float[Array, ""]
    surroundings: Float[Array, ""]
    power: Float[Array, ""]
    profile: Float[Array, "faces points"]
    schedule: Schedule
    path: LightPath
    exposed: Float[Array, " faces"]
    own: Float[Array, " faces"]
    known: Float[Array, " faces"]
    warmer: Float[Array, " faces"]
    prescribed: PrescribedTemperature | None

    def start(self, count: int) -> Float[Array, " nodes"]:
        """Temperatures [K] of `count` nodes at t = 0."""
        return jnp.full(count, self.initial)


def _prescribe(run: Run, space: Discretisation) -> PrescribedTemperature | None:
    if not run.prescribed:
        return None
    patch = np.full(len(space.mesh.nodes), -1, np.int32)
    surface = np.unique(space.mesh.faces)
    place, slack = space.mesh.nodes[surface], _slack(space)
    for number, item in enumerate(run.prescribed):
        inside = item.box().holds(place, slack)
        if not inside.any():
            what = "no surface node lies in the box of a prescribed temperature"
            raise misses(
                what, f"runs.{run.name}.prescribed[{number}].box", item.box(), space.mesh.nodes
            )
        patch[surface[inside]] = number
    histories = tuple(
        History(jnp.asarray(item.time), jnp.asarray(item.temperature)) for item in run.prescribed
    )
    return PrescribedTemperature(jnp.asarray(patch), histories)


def _slack(space: Discretisation) -> float:
    return SLACK * float(np.linalg.norm(np.ptp(space.mesh.nodes, axis=0)))


def _expose(run: Run, space: Discretisation) -> Float[np.ndarray, " faces"]:
    exposed = np.ones(len(space.mesh.faces))
    for number, box in enumerate(run.insulated):
        exposed[_faces_in(box, space, f"runs.{run.name}.insulated[{number}]")] = 0.0
    return exposed


def _air(run: Run, space: Discretisation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`own`, `known` and `warmer` of `Conditions`."""
    count = len(space.mesh.faces)
    own, known, warmer = np.ones(count), np.zeros(count), np.zeros(count)
    for number, one in enumerate(run.air):
        inside = _faces_in(one.box, space, f"runs.{run.name}.air[{number}].box")
        own[inside], known[inside] = 0.0, one.convection
        warmer[inside] = one.temperature - run.ambient_temperature
    return own, known, warmer


def _faces_in(box: Box, space: Discretisation, where: str) -> Bool[np.ndarray, " faces"]:
    centres = space.mesh.nodes[space.mesh.faces[:, :3]].mean(1)
    inside = box.holds(centres, _slack(space))
    if not inside.any():
        raise misses("no face has its centre in this box", where, box, space.mesh.nodes)
    return inside


def _schedule(heater: Heater) -> Schedule:
    course = heater.course
    logged = None
    if course is not None:
        logged = History(jnp.asarray(course.time), jnp.asarray(course.share))
    until, rise = jnp.asarray(float(heater.until)), jnp.asarray(float(heater.rise))
    return Schedule(until, rise, logged, jnp.asarray(0.0))


def conditions(run: Run, space: Discretisation) -> Conditions:
    """Put a run's conditions on a mesh.

    Arguments:

    - `run`: temperatures [K], lamp [W], prescribed histories [K].
    - `space`: the discretised body.

    Raises `InputError` where the lamp, the box of a prescribed temperature, of insulation or of
    air misses the surface.
    """
    heater = run.heater
    profile, path = np.zeros(np.shape(space.face_weight)), dark(len(space.mesh.cells))
    power, schedule = 0.0, Schedule(jnp.zeros(()), jnp.zeros(()), None, jnp.zeros(()))
    if heater is not None:
        try:
            profile = spot_profile(
                space, centre=heater.centre, direction=heater.direction, radius=heater.radius
            )
        except ValueError as miss:
            raise InputError(
                "the lamp does not reach the object",
                where=f"runs.{run.name}.heater",
                value=f"centre {heater.centre.tolist()} m, direction {heater.direction.tolist()}",
                limit="an axis whose light meets the surface",
                remedy="check centre and direction, in metres and in the surface's axes",
            ) from miss
        power = heater.power
        schedule, path = _schedule(heater), light_path(heater, space)
    own, known, warmer = _air(run, space)
    return Conditions(
        initial=jnp.asarray(float(run.initial_temperature)),
        ambient=jnp.asarray(float(run.ambient_temperature)),
        surroundings=jnp.asarray(float(run.radiation_temperature)),
        power=jnp.asarray(float(power)),
        profile=jnp.asarray(profile),
        schedule=schedule,
        path=path,
        exposed=jnp.asarray(_expose(run, space)),
        own=jnp.asarray(own),
        known=jnp.asarray(known),
        warmer=jnp.asarray(warmer),
        prescribed=_prescribe(run, space),
    )


def make_model(
    space: Discretisation, body: Properties, under: Conditions, *, lagged: bool = False
) -> Model:
    """The heat equation of a body under a run's conditions.

    Arguments:

    - `body`: properties [SI]; `under`: the run's conditions [K, W].
    - `lagged`: the paper's lagged radiation in place of the full fourth power.
    """
    kind = LaggedRadiation if lagged else Radiation
    film = (body.convection * under.own + under.known) * under.exposed
    surface = (
        Convection(film, under.ambient, under.warmer),
        kind(body.emissivity * under.exposed, under.surroundings),
        Heating(under.power, under.profile, under.schedule),
    )
    return Model(
        space, body.conductivity, body.capacity, surface=surface, prescribed=under.prescribed,
        conductivity_law=body.conductivity_law, capacity_law=body.capacity_law,
    )  # fmt: skip

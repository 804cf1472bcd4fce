"""The lamp that heats the object from one side."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError

from ._course import Course
from ._number import check_number, check_vector


@final
class Heater(eqx.Module):
    """A lamp with a Gaussian spot.

    Its flux on the surface is proportional to exp(-r^2 / (2 radius^2)) max(-n . direction, 0),
    where r is the distance from the axis and n the outward normal, and is scaled so that its
    integral over the surface is `power`. With `rise` it warms up and cools down with that time
    constant; with a `course` its power is that share of `power` besides.

    Arguments:

    - `centre`: a point of the axis, (3,) [m].
    - `direction`: the way the light goes, (3,); stored as a unit vector.
    - `radius`: standard deviation of the spot [m].
    - `power`: power that the surface takes up [W].
    - `until`: it is on for 0 <= t < `until` [s].
    - `rise`: time constant of warming up and cooling down [s]; 0 switches at once.
    - `course`: shares of the power that were logged, or None where it was constant.
    - `where`: what messages call this heater.

    Raises `InputError` for anything that is not finite, a zero direction, a radius, power or
    `until` that is not positive, a negative `rise`, and a course that begins when the lamp is off.
    """

    centre: Float[np.ndarray, "3"]
    direction: Float[np.ndarray, "3"]
    radius: float
    power: float
    until: float
    rise: float
    course: Course | None

    def __init__(
        self,
        centre: ArrayLike,
        direction: ArrayLike,
        radius: float,
        power: float,
        until: float,
        rise: float = 0.0,
        course: Course | None = None,
        *,
        where: str = "heater",
    ) -> None:
        self.centre = check_vector(
            centre, where=f"{where}.centre", quantity="centre of the lamp [m]"
        )
        self.direction = _unit(direction, f"{where}.direction")
        self.radius = check_number(
            radius, where=f"{where}.radius", quantity="radius of the spot [m]", above=0.0,
            remedy="give the standard deviation of the spot in metres",
        )  # fmt: skip
        self.power = check_number(
            power, where=f"{where}.power", quantity="power of the lamp [W]", above=0.0,
            remedy='give the absorbed power in watts; without a lamp write "heater": null',
        )  # fmt: skip
        self.until = check_number(
            until, where=f"{where}.until", quantity="time when the lamp goes off [s]", above=0.0,
            remedy='give seconds after the start of the run; without a lamp write "heater": null',
        )  # fmt: skip
        self.rise = check_number(
            rise, where=f"{where}.rise", quantity="time constant of the lamp [s]", least=0.0,
            remedy="give seconds, or 0 for a lamp that switches at once",
        )  # fmt: skip
        self.course = _while_on(course, self.until, f"{where}.course.time")

    def first_light(self) -> float:
        """When it begins to shine [s]."""
        if self.course is None:
            return 0.0
        lit = int(np.flatnonzero(self.course.share > 0)[0])
        return max(float(self.course.time[lit - 1]), 0.0) if lit else 0.0


def _while_on(course: Course | None, until: float, where: str) -> Course | None:
    if course is not None and course.time[0] >= until:
        raise InputError(
            "the course of the lamp begins when it is off", where=where,
            value=f"{course.time[0]:g} s", limit=f"below {until:g} s, `until`",
            remedy="give what was logged while the lamp was on, in seconds after the start",
        )  # fmt: skip
    return course


def _unit(direction: object, where: str) -> np.ndarray:
    vector = check_vector(direction, where=where, quantity="direction of the lamp")
    largest = np.abs(vector).max()
    if largest == 0:
        raise InputError(
            "direction of the lamp has no length", where=where, value=vector.tolist(),
            limit="a vector other than zero",
            remedy="give the way the light goes, for example [0, 0, -1]",
        )  # fmt: skip
    scaled = vector / largest  # keeps the norm of very small vectors from underflow
    length = np.linalg.norm(scaled)
    # A unit vector is left as it is, so that writing and reading a scene changes no bit.
    return vector if abs(largest * length - 1.0) < 1e-12 else scaled / length

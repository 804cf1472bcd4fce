"""The heat equation with everything that may be hidden, in quadratic functions and by TR-BDF2."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import SuperLU, splu
from scipy.special import ndtr

from hidden._bodies import Body

SIGMA = 5.670374419e-8
# TR-BDF2 (Bank et al. 1985): its first stage ends at this share of a step.
GAMMA = 2 - np.sqrt(2.0)
IMPLICIT = GAMMA / 2
COLD = 295.15


@dataclass(frozen=True)
class Lamp:
    """A spot that warms up and cools down with a time constant [m, W, s]."""

    centre: tuple[float, float, float]
    direction: tuple[float, float, float]
    radius: float
    power: float
    until: float
    rise: float

    def course(self, time: float) -> float:
        """Share of its power at a time [s]."""
        on = 1 - np.exp(-max(min(time, self.until), 0.0) / self.rise)
        return float(on * np.exp(-max(time - self.until, 0.0) / self.rise))

    def shape(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Flux on a surface before it is scaled to the power [1]."""
        way = np.asarray(self.direction) / np.linalg.norm(self.direction)
        apart = points - np.asarray(self.centre)
        apart = apart - np.outer(apart @ way, way)
        near = np.exp(-(apart**2).sum(1) / (2 * self.radius**2))
        return near * np.maximum(-normals @ way, 0.0)


def ones(points: np.ndarray) -> np.ndarray:
    """One at every point."""
    return np.ones(len(points))


def nothing(points: np.ndarray) -> np.ndarray:
    """Zero at every point."""
    return np.zeros(len(points))


Shape = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Physics:
    """A body's properties and surroundings, functions of points [m] where they vary in space.

    - `along`: factors of the conductivity along x, y, z [1]; `factor`, `capacity_factor`: over
      space [1].
    - `conductivity_slope`, `capacity_slope` by temperature, about 293.15 K [1/K].
    - `transition`: latent heat [J/kg], its middle and width on the scale of temperature [K].
    - `contact`: towards `COLD` [W/m2/K]; `source` [W/m3]; `vapour` [W/m2/Pa].
    - `drift`: of the air over time [K]; `deep`: share of the light that is absorbed below
      the skin, over a `depth` [m]; `shade`: share of the light that arrives [1]; `start`: what the
      initial temperature is off by [K].
    """

    density: float
    capacity: float
    conductivity: float
    convection: float = 8.0
    emissivity: float = 0.85
    along: tuple[float, float, float] = (1.0, 1.0, 1.0)
    factor: Shape = ones
    capacity_factor: Shape = ones
    conductivity_slope: float = 0.0
    capacity_slope: float = 0.0
    transition: tuple[float, float, float] | None = None
    extra_convection: Shape = nothing
    contact: Shape = nothing
    source: Shape = nothing
    vapour: float = 0.0
    drift: Callable[[float], float] = field(default=lambda time: 0.0)
    deep: float = 0.0
    depth: float = 1e-3
    shade: Shape = ones
    start: Shape = nothing


def _below(body: Body, way: np.ndarray) -> np.ndarray:
    """How deep points inside lie below the skin, back along the light's way [m]."""
    deep = np.zeros(len(body.at))
    rays = body.surface.ray
    hits, which, _ = rays.intersects_location(
        body.at, np.broadcast_to(-way, body.at.shape), multiple_hits=False
    )
    deep[which] = np.linalg.norm(hits - body.at[which], axis=1)
    return deep


def pressure(temperature: np.ndarray | float) -> np.ndarray | float:
    """Of saturated vapour [Pa], Magnus's formula."""
    return 610.94 * np.exp(17.625 * (temperature - 273.15) / (temperature - 30.11))


@dataclass
class Heat:
    """Nodal heat flows [W] of a body under given physics.

    Stiff and linear parts are in `matrix`, everything else in `rest`.
    """

    body: Body
    physics: Physics
    lamp: Lamp | None

    def __post_init__(self) -> None:
        """Put together what does not change."""
        body, physics = self.body, self.physics
        self.room = body.weight * physics.density * physics.capacity
        self.room = self.room * physics.capacity_factor(body.at)
        self.mass = csc_array(body.values.T @ diags_array(self.room) @ body.values)
        spread = physics.conductivity * physics.factor(body.at) * body.weight
        self.spread = [share * spread for share in physics.along]
        pairs = zip(body.slopes, self.spread, strict=True)
        stiff = sum(way.T @ diags_array(one) @ way for way, one in pairs)
        self.air = physics.convection + physics.extra_convection(body.skin_at)
        self.support = physics.contact(body.skin_at)
        self.glow = physics.emissivity * SIGMA
        linear = self.air + self.support + 4 * self.glow * COLD**3
        skin = body.skin.T @ diags_array(body.skin_weight * linear) @ body.skin
        self.matrix = csc_array(stiff + skin)
        self.linear = linear
        self.constant = body.values.T @ (body.weight * physics.source(body.at))
        self.light = self._light() if self.lamp else np.zeros(body.skin.shape[1])
        self.factors: dict[float, SuperLU] = {}

    def _light(self) -> np.ndarray:
        """Nodal heat at full power [W]."""
        body, physics, lamp = self.body, self.physics, self.lamp
        assert lamp is not None, "no lamp is lit"
        shape = lamp.shape(body.skin_at, body.skin_normal)
        shape = shape / (shape @ body.skin_weight) * physics.shade(body.skin_at)
        made = lamp.power * (1 - physics.deep) * body.skin.T @ (body.skin_weight * shape)
        if physics.deep:
            way = np.asarray(lamp.direction)
            below = _below(body, way)
            inside = lamp.shape(body.at, np.broadcast_to(-way, body.at.shape))
            inside = inside * np.exp(-below / physics.depth)
            inside *= lamp.power * physics.deep / (inside @ body.weight)
            made += body.values.T @ (body.weight * inside)
        return made

    def rest(self, temperature: np.ndarray, time: float) -> np.ndarray:
        """All but `matrix` times temperature [W] at a time [s]."""
        body, physics = self.body, self.physics
        air = COLD + physics.drift(time)
        skin = body.skin @ temperature
        flux = self.air * (air - skin) + self.support * (COLD - skin)
        flux += self.glow * (COLD**4 - skin**4) + self.linear * skin
        if physics.vapour:
            flux += physics.vapour * (0.5 * pressure(COLD) - pressure(skin))
        made = self.constant + body.skin.T @ (body.skin_weight * flux)
        if self.lamp:
            made += self.lamp.course(time) * self.light
        if physics.conductivity_slope:
            more = physics.conductivity_slope * (body.values @ temperature - 293.15)
            for way, one in zip(body.slopes, self.spread, strict=True):
                made -= way.T @ (one * more * (way @ temperature))
        return made

    def stored(self, temperature: np.ndarray) -> np.ndarray:
        """Nodal heat beyond the linear part [J]."""
        physics = self.physics
        if not physics.capacity_slope and physics.transition is None:
            return np.zeros(len(temperature))
        inside = self.body.values @ temperature
        more = physics.capacity_slope * (inside - 293.15) ** 2 / 2
        if physics.transition is not None:
            latent, middle, width = physics.transition
            more += latent / physics.capacity * ndtr((inside - middle) / width)
        return self.body.values.T @ (self.room * more)

    def peak(self) -> float:
        """Half of what a transition adds to the capacity at the most, over the capacity [1]."""
        if self.physics.transition is None:
            return 0.0
        latent, _, width = self.physics.transition
        return latent / (self.physics.capacity * width * np.sqrt(8 * np.pi))

    def solve(self, size: float, right: np.ndarray) -> np.ndarray:
        """((1 + peak) mass + IMPLICIT size matrix)^-1."""
        if size not in self.factors:
            taken = (1 + self.peak()) * self.mass
            self.factors[size] = splu(csc_array(taken + IMPLICIT * size * self.matrix))
        return self.factors[size].solve(right)

    def stage(self, known: np.ndarray, guess: np.ndarray, size: float, time: float) -> np.ndarray:
        """Solve heat(T) = known + IMPLICIT size f(T) by fixed point on what is not linear.

        Half of what a transition adds at the most stands on the left, so that it contracts.
        """
        for _ in range(200):
            right = known - self.stored(guess) + IMPLICIT * size * self.rest(guess, time)
            right += self.peak() * (self.mass @ guess)
            after = self.solve(size, right)
            if np.abs(after - guess).max() < 1e-5:
                return after
            guess = after
        raise RuntimeError("the fixed point of a step was not found")

    def step(
        self, before: np.ndarray, rate: np.ndarray, time: float, size: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Temperatures [K] one step later, and by how much they change there [K/s]."""
        heat = self.mass @ before + self.stored(before)
        flow = self.rest(before, time) - self.matrix @ before
        ahead = before + GAMMA * size * rate
        middle = self.stage(heat + IMPLICIT * size * flow, ahead, size, time + GAMMA * size)
        half = self.mass @ middle + self.stored(middle)
        known = (half - (1 - GAMMA) ** 2 * heat) / (GAMMA * (2 - GAMMA))
        ahead = before + (middle - before) / GAMMA
        after = self.stage(known, ahead, size, time + size)
        return after, (after - middle) / ((1 - GAMMA) * size)


def steps(lamp: Lamp | None, end: float, finer: float = 1.0) -> np.ndarray:
    """Times [s] to step through: short after a switch, longer where all is smooth."""
    switches = [0.0] if lamp is None else [0.0, lamp.until]
    made, time = [0.0], 0.0
    while time < end - 1e-9:
        since = min(time - one for one in switches if one <= time + 1e-9)
        size = (0.1 if since < 0.999 else 0.25 if since < 2.999 else 1.0) / finer
        made.append(time := round(time + size, 9))
    return np.array(made)


def simulate(
    body: Body, physics: Physics, lamp: Lamp | None, initial: float, end: float, finer: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Steps [s] and what the body's samples are at there [K]."""
    heat = Heat(body, physics, lamp)
    time = steps(lamp, end, finer)
    nodes = np.full(body.skin.shape[1], initial)
    if physics.start is not nothing:
        shape = heat.body.values.T @ (heat.room * physics.start(body.at))
        nodes = nodes + splu(heat.mass).solve(shape)
    rate = np.zeros(len(nodes))
    found = [body.reading @ nodes]
    for begin, size in zip(time[:-1], np.diff(time), strict=True):
        nodes, rate = heat.step(nodes, rate, begin, round(size, 9))
        found.append(body.reading @ nodes)
    return time, np.array(found)

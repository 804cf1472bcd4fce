"""What may be hidden in a recording: effects of the library, effects that it lacks, and pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from scipy.signal import lfilter
from trimesh.intersections import slice_faces_plane

from hidden._bodies import Body
from hidden._heat import COLD, Lamp, Physics

Read = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def as_is(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Temperatures [K] as they are."""
    del time, points
    return temperature


@dataclass(frozen=True)
class Hidden:
    """An effect at work.

    - `kind`; `strength` in the unit of the library's card; `where` [m], None without a place.
    - `physics`, `lamp` change what is simulated; `read` what is read of steps a tenth of a second
      apart; `stated` changes what the scene states.
    """

    kind: str
    strength: float = 0.0
    where: tuple[float, ...] | None = None
    physics: Callable[[Physics], Physics] = lambda one: one
    lamp: Callable[[Lamp], Lamp] = lambda one: one
    read: Read = as_is
    stated: Callable[[Physics], Physics] = lambda one: one

    def simulated(self) -> bool:
        """Whether the simulation differs, not only what is read of it."""
        return self.read is as_is


def _ball(centre: np.ndarray, size: float | np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    return lambda at: np.exp(-(((at - centre) / size) ** 2).sum(1) / 2)


def _box(centre: np.ndarray, size: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    def inside(at: np.ndarray) -> np.ndarray:
        edge = 0.15 * size
        return np.prod(1 / (1 + np.exp((np.abs(at - centre) - size) / edge)), axis=1)

    return inside


def _uniform(random: np.random.Generator, low: float, high: float) -> float:
    """Even in the logarithm."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _on_skin(random: np.random.Generator, body: Body) -> np.ndarray:
    share = body.skin_weight / body.skin_weight.sum()
    return body.skin_at[random.choice(len(share), p=share)]


def _within(random: np.random.Generator, body: Body) -> np.ndarray:
    share = np.maximum(body.weight, 0.0)  # a point of each cell has a negative weight
    share /= share.sum()
    return body.at[random.choice(len(share), p=share)]


def _sign(random: np.random.Generator) -> float:
    return float(random.choice([-1.0, 1.0]))


def _longest(body: Body) -> float:
    return float(np.ptp(body.skin_at, axis=0).max())


def radiation(random: np.random.Generator, body: Body) -> Hidden:
    """Nothing is said of radiation."""
    del body
    share = random.uniform(0.3, 0.95)
    return Hidden(
        "radiation", share, stated=lambda one: replace(one, emissivity=0.0),
        physics=lambda one: replace(one, emissivity=share),
    )  # fmt: skip


def local_convection(random: np.random.Generator, body: Body) -> Hidden:
    """A draught on a patch."""
    where, size = _on_skin(random, body), random.uniform(0.12, 0.25) * _longest(body)
    strength = _uniform(random, 15, 150)
    shape = _ball(where, size)
    return Hidden(
        "local_convection", strength, tuple(where),
        physics=lambda one: replace(one, extra_convection=lambda at: strength * shape(at)),
    )  # fmt: skip


def support_contact(random: np.random.Generator, body: Body) -> Hidden:
    """A support as warm as the surroundings below the lowest part along an axis."""
    axis, strength = int(random.integers(3)), _uniform(random, 30, 400)
    low, depth = body.skin_at[:, axis].min(), 0.1 * np.ptp(body.skin_at[:, axis])
    near = body.skin_at[:, axis] < low + depth
    # The edge falls between points of the rule, which hold a few per cent more or less than lies
    # within it: over these the strength is as much less or more.
    strength *= _area_below(body, axis, low + depth) / body.skin_weight[near].sum()

    def shape(at: np.ndarray) -> np.ndarray:
        return strength * (at[:, axis] < low + depth)

    where = tuple(np.average(body.skin_at[near], axis=0, weights=body.skin_weight[near]))
    return Hidden(
        "support_contact", strength, where, physics=lambda one: replace(one, contact=shape)
    )


def _area_below(body: Body, axis: int, level: float) -> float:
    """Area of the skin [m2] that lies below a level [m] along an axis."""
    skin, up = body.surface, np.eye(3)[axis]
    corners, faces, _ = slice_faces_plane(skin.vertices, skin.faces, -up, level * up)
    return float(trimesh.triangles.area(corners[faces]).sum())


def hidden_source(random: np.random.Generator, body: Body) -> Hidden:
    """Something warm inside."""
    where, size = _within(random, body), random.uniform(0.08, 0.15) * _longest(body)
    return _source(random, body, where, _ball(where, size))


def void(random: np.random.Generator, body: Body) -> Hidden:
    """A place that conducts poorly."""
    where = 0.7 * _within(random, body)
    size = random.uniform([0.12] * 3, [0.2] * 3) * np.ptp(body.skin_at, axis=0)
    strength = random.uniform(0.6, 0.97)
    shape = _box(where, size)
    return Hidden(
        "void", strength, tuple(where),
        physics=lambda one: replace(one, factor=lambda at: 1 - strength * shape(at)),
    )  # fmt: skip


def anisotropic_conductivity(random: np.random.Generator, body: Body) -> Hidden:
    """One axis conducts otherwise."""
    del body
    strength, axis = _uniform(random, 0.1, 0.8), int(random.integers(3))
    along = tuple(1 + strength * (number == axis) for number in range(3))
    return Hidden(
        "anisotropic_conductivity", strength, physics=lambda one: replace(one, along=along)
    )


def temperature_dependent_conductivity(random: np.random.Generator, body: Body) -> Hidden:
    """Conductivity by temperature."""
    del body
    slope = _sign(random) * _uniform(random, 5e-4, 4e-3)
    return Hidden(
        "temperature_dependent_conductivity", slope,
        physics=lambda one: replace(one, conductivity_slope=slope),
    )  # fmt: skip


def temperature_dependent_heat_capacity(random: np.random.Generator, body: Body) -> Hidden:
    """Capacity by temperature."""
    del body
    slope = _sign(random) * _uniform(random, 5e-4, 4e-3)
    return Hidden(
        "temperature_dependent_heat_capacity", slope,
        physics=lambda one: replace(one, capacity_slope=slope),
    )  # fmt: skip


def latent_heat(random: np.random.Generator, body: Body) -> Hidden:
    """A phase that changes over a range of temperature."""
    del body
    strength, width = _uniform(random, 1e3, 4e4), random.uniform(2.0, 6.0)
    middle = COLD + random.uniform(3.0, 50.0)
    return Hidden(
        "latent_heat", strength,
        physics=lambda one: replace(one, transition=(strength, middle, width)),
    )  # fmt: skip


def ambient_drift(random: np.random.Generator, body: Body) -> Hidden:
    """Surroundings that warm up or cool down."""
    del body
    end = _sign(random) * _uniform(random, 1.5, 12)
    return Hidden(
        "ambient_drift", end, physics=lambda one: replace(one, drift=lambda time: end * time / 60)
    )


def evaporation(random: np.random.Generator, body: Body) -> Hidden:
    """A wet skin."""
    del body
    strength = _uniform(random, 0.003, 0.05)
    return Hidden("evaporation", strength, physics=lambda one: replace(one, vapour=strength))


def heater_power(random: np.random.Generator, body: Body) -> Hidden:
    """Lamps of another power."""
    del body
    share = _sign(random) * _uniform(random, 0.02, 0.3)
    return Hidden(
        "heater_power", share, lamp=lambda one: replace(one, power=(1 + share) * one.power)
    )


def heater_lag(random: np.random.Generator, body: Body) -> Hidden:
    """Lamps that warm up more slowly."""
    del body
    more = _uniform(random, 0.3, 4.0)
    return Hidden("heater_lag", more, lamp=lambda one: replace(one, rise=one.rise + more))


def sensor_lag(random: np.random.Generator, body: Body) -> Hidden:
    """A slow sensor."""
    del body
    lag = _uniform(random, 0.3, 4.0)

    def read(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
        del points
        # Of straight lines between steps, exactly.
        kept = np.exp(-(time[1] - time[0]) / lag)
        slope = np.diff(temperature, axis=0) / (time[1] - time[0])
        late = lfilter([1.0], [1.0, -kept], -lag * (1 - kept) * slope, axis=0)
        return temperature + np.concatenate([np.zeros_like(temperature[:1]), late])

    return Hidden("sensor_lag", lag, read=read)


def clock_offset(random: np.random.Generator, body: Body) -> Hidden:
    """Frames earlier or later than their stamps."""
    del body
    offset = round(_sign(random) * _uniform(random, 0.3, 3.0), 1)

    def read(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
        del points
        at = np.clip(np.round((time + offset) / 0.1).astype(int), 0, len(time) - 1)
        return temperature[at]

    return Hidden("clock_offset", offset, read=read)


def camera_emissivity(random: np.random.Generator, body: Body) -> Hidden:
    """A camera of another scale."""
    del body
    share = _sign(random) * _uniform(random, 0.005, 0.1)

    def read(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
        del time, points
        return temperature + share * (temperature - COLD)

    return Hidden("camera_emissivity", share, read=read)


def in_depth_absorption(random: np.random.Generator, body: Body) -> Hidden:
    """Light that reaches below the skin."""
    share = random.uniform(0.5, 1.0)
    depth = random.uniform(0.04, 0.1) * float(np.ptp(body.skin_at, axis=0).min())
    return Hidden(
        "in_depth_absorption", share, physics=lambda one: replace(one, deep=share, depth=depth)
    )


def draught_in_a_box(random: np.random.Generator, body: Body) -> Hidden:
    """A draught on a patch that is even, with an edge, and not as wide one way as the other."""
    where = _on_skin(random, body)
    size = random.uniform([0.1] * 3, [0.25] * 3) * np.ptp(body.skin_at, axis=0)
    strength, shape = _uniform(random, 15, 150), _box(where, size)
    return Hidden(
        "local_convection", strength, tuple(where),
        physics=lambda one: replace(one, extra_convection=lambda at: strength * shape(at)),
    )  # fmt: skip


def source_in_a_box(random: np.random.Generator, body: Body) -> Hidden:
    """Something warm inside that is even and has an edge."""
    where = _within(random, body)
    size = random.uniform([0.08] * 3, [0.2] * 3) * np.ptp(body.skin_at, axis=0)
    return _source(random, body, where, _box(where, size))


def source_along_a_rod(random: np.random.Generator, body: Body) -> Hidden:
    """A wire: something warm inside that is long one way and thin the others."""
    where, size = _within(random, body), np.full(3, random.uniform(0.04, 0.06) * _longest(body))
    size[int(np.argmax(np.ptp(body.skin_at, axis=0)))] *= random.uniform(3, 5)
    return _source(random, body, where, _ball(where, size))


def _source(
    random: np.random.Generator,
    body: Body,
    where: np.ndarray,
    shape: Callable[[np.ndarray], np.ndarray],
) -> Hidden:
    power, whole = _uniform(random, 0.1, 3.0), shape(body.at) @ body.weight
    return Hidden(
        "hidden_source", power, tuple(where),
        physics=lambda one: replace(one, source=lambda at: power * shape(at) / whole),
    )  # fmt: skip


def round_void(random: np.random.Generator, body: Body) -> Hidden:
    """A place that conducts poorly, an ellipsoid that fades towards its edge."""
    where = 0.7 * _within(random, body)
    size = random.uniform([0.08] * 3, [0.13] * 3) * np.ptp(body.skin_at, axis=0)
    strength, shape = random.uniform(0.6, 0.97), _ball(where, size)
    return Hidden(
        "void", strength, tuple(where),
        physics=lambda one: replace(one, factor=lambda at: 1 - strength * shape(at)),
    )  # fmt: skip


def capacity_patch(random: np.random.Generator, body: Body) -> Hidden:
    """A place that holds more heat, or less."""
    where, size = 0.7 * _within(random, body), random.uniform(0.15, 0.25) * _longest(body)
    strength = _sign(random) * random.uniform(0.2, 0.6)
    shape = _ball(where, size)
    return Hidden(
        "capacity_patch", strength, tuple(where),
        physics=lambda one: replace(one, capacity_factor=lambda at: 1 + strength * shape(at)),
    )  # fmt: skip


def conducting_insert(random: np.random.Generator, body: Body) -> Hidden:
    """A place that conducts better."""
    where, size = 0.7 * _within(random, body), random.uniform(0.15, 0.25) * _longest(body)
    strength = _uniform(random, 1.0, 5.0)
    shape = _ball(where, size)
    return Hidden(
        "conducting_insert", strength, tuple(where),
        physics=lambda one: replace(one, factor=lambda at: 1 + strength * shape(at)),
    )  # fmt: skip


def displaced_lamp(random: np.random.Generator, body: Body) -> Hidden:
    """A spot that is not where it is said to be."""
    del body
    way, far = random.uniform(0, 2 * np.pi), _uniform(random, 0.0005, 0.004)

    def moved(lamp: Lamp) -> Lamp:
        x, y, z = lamp.centre
        return replace(lamp, centre=(x + far * np.cos(way), y + far * np.sin(way), z))

    return Hidden("displaced_lamp", far, lamp=moved)


def uneven_start(random: np.random.Generator, body: Body) -> Hidden:
    """A body that is warmer on one side when a run starts."""
    way = random.standard_normal(3)
    way /= np.linalg.norm(way)
    size = _uniform(random, 0.3, 3.0) / _longest(body)
    return Hidden(
        "uneven_start", size, physics=lambda one: replace(one, start=lambda at: size * (at @ way))
    )


def shaded_lamp(random: np.random.Generator, body: Body) -> Hidden:
    """Something that keeps a part of the light off."""
    del body
    way, share = random.uniform(0, 2 * np.pi), random.uniform(0.1, 0.6)
    across = np.array([np.cos(way), np.sin(way), 0.0])

    def arrives(at: np.ndarray) -> np.ndarray:
        return 1 - share / (1 + np.exp(-(at @ across) / 0.001))

    return Hidden("shaded_lamp", share, physics=lambda one: replace(one, shade=arrives))


def blurred_camera(random: np.random.Generator, body: Body) -> Hidden:
    """A camera out of focus: each sample reads a mean over its neighbours."""
    size = random.uniform(0.08, 0.15) * _longest(body)

    def read(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
        del time
        apart = ((points[:, None] - points[None]) ** 2).sum(-1)
        weight = np.exp(-apart / (2 * size**2))
        return temperature @ (weight / weight.sum(1, keepdims=True)).T

    return Hidden("blurred_camera", size, read=read)


def drifting_camera(random: np.random.Generator, body: Body) -> Hidden:
    """A camera that reads more and more."""
    del body
    rate = _sign(random) * _uniform(random, 0.002, 0.03)

    def read(time: np.ndarray, temperature: np.ndarray, points: np.ndarray) -> np.ndarray:
        del points
        return temperature + rate * time[:, None]

    return Hidden("drifting_camera", rate, read=read)


WITHIN = (
    radiation, local_convection, support_contact, hidden_source, void, anisotropic_conductivity,
    temperature_dependent_conductivity, temperature_dependent_heat_capacity, ambient_drift,
    evaporation, heater_power, heater_lag, sensor_lag, clock_offset, camera_emissivity,
    in_depth_absorption, latent_heat,
)  # fmt: skip
"""Effects that the library has."""

OUTSIDE = (
    capacity_patch, conducting_insert, displaced_lamp, uneven_start, shaded_lamp, blurred_camera,
    drifting_camera,
)  # fmt: skip
"""Effects that it lacks."""

FORMS = (draught_in_a_box, source_in_a_box, source_along_a_rod, round_void)
"""Effects that the library has, at places of another form than it takes them to have."""

PAIRS = (
    (hidden_source, sensor_lag), (local_convection, anisotropic_conductivity),
    (support_contact, heater_lag), (void, camera_emissivity), (heater_power, hidden_source),
    (anisotropic_conductivity, ambient_drift),
)  # fmt: skip
"""Effects that are hidden together."""

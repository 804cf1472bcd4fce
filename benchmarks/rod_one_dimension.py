"""What a rod model in one dimension, independent of ThermoField, finds in the steel rod.

    python benchmarks/rod_one_dimension.py [DATA_FOLDER]

`examples/steel_rod.py` leaves 0.14 K rms at the six inner couples as they were read. Is that its
solver's fault, its assumptions' or the couples'? This asks the same record (see that file for where
it is from) by central differences and the trapezoidal rule on 71 points, with one assumption after
another let go:

- the room's temperature, which nobody logged, may differ from the rod's mean at the start;
- the couples at the ends, whose readings are prescribed there, may be off by a constant each,
  also with the room at some temperatures of a laboratory;
- all eight couples may be off by a constant of some deviation, and the room by another, with
  Gaussian priors; the likelihood then takes the 60 readings of ten minutes as one;
- the couples at the ends alone may be off, by 0.3 K as couples of this rod are known to be, in a
  room of 22 +- 3 C, a laboratory's; with the readings of ten minutes as one, or all of a couple's,
  since what is left is constant;
- the inner couples are set right by their first two minutes, when the rod is steady.

`rmse` is that of the inner couples as they were read (in the last line as they were set right),
`rmse_free` less one constant a couple.
Writes `benchmarks/results/rod_one_dimension.csv`.
"""

from __future__ import annotations

import csv
import os
import sys
from collections.abc import Callable
from copy import copy
from pathlib import Path
from typing import Final

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import least_squares

ROOT: Final = Path(__file__).resolve().parents[1]
RESULTS: Final = ROOT / "benchmarks" / "results" / "rod_one_dimension.csv"
RECORD: Final = Path("measured/cu_boulder_rods/2019_Steel_20V_185mA.txt")
RADIUS = SPACING = 0.0127  # m
CAPACITY = 4e6  # J/m3/K, of the laboratory's sheet
TABLE = 4.05  # mm2/s, of the laboratory's sheet
POINTS, BETWEEN = 71, 10  # grid points, and those from couple to couple
STEP = 30.0  # s
BLOCK = 12  # readings, two minutes, of which the mean is prescribed at the ends
ROOMS = (20.0, 22.0, 24.0, 25.0)  # C
RESOLUTION, ALIKE = 0.1, 60  # K of a couple; readings that count as one
LABORATORY, OFF = (22.0, 3.0), 0.3  # C, a room and its deviation; K, of a couple at an end
FIRST = (4.0, 5.0)  # mm2/s, W/m2/K

Ends = tuple[np.ndarray, np.ndarray]


def read_record(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (frames,) [s] and temperatures (frames, 8) [C]."""
    path = folder / RECORD
    if not path.is_file():
        sys.exit(f"no {path}: give DATA_FOLDER or set THERMOFIELD_DATA")
    lines = [line for line in path.read_text("utf-8").splitlines() if len(line.split()) > 8]
    table = np.loadtxt(lines[1:], usecols=range(9))
    return table[:, 0], table[:, 1:]


def end_histories(time: np.ndarray, read: np.ndarray, at: np.ndarray) -> Ends:
    """What the couples of both ends read at times [s], smoothed over blocks [C]."""
    whole = len(time) // BLOCK * BLOCK
    middle = time[:whole].reshape(-1, BLOCK).mean(1)

    def smooth(couple: int) -> np.ndarray:
        mean = read[:whole, couple].reshape(-1, BLOCK).mean(1)
        stamps = np.concatenate([[0.0], middle, [time[-1]]])
        return np.interp(at, stamps, np.concatenate([[read[0, couple]], mean, [mean[-1]]]))

    return smooth(0), smooth(7)


def banded(diagonal: float, beside: float) -> np.ndarray:
    """A matrix of three diagonals, (3, points), with both ends held."""
    matrix = np.zeros((3, POINTS))
    matrix[0, 2:] = matrix[2, :-2] = beside
    matrix[1] = diagonal
    matrix[1, 0] = matrix[1, -1] = 1.0
    return matrix


def inner_couples(
    diffusivity: float, loss: float, room: float, ends: Ends, grid: np.ndarray, time: np.ndarray
) -> np.ndarray:
    """Temperatures (frames, 6) [C] of dT/dt = a T'' - 2 h / (R rho c) (T - room).

    Arguments: `diffusivity` [mm2/s]; `loss` h [W/m2/K]; `room` [C]; `ends` at times `grid` [s].
    It starts in the steady state of the first readings.
    """
    spread = 1e-6 * diffusivity / (SPACING / BETWEEN) ** 2
    sink = 2 * loss / (RADIUS * CAPACITY)

    def held(values: np.ndarray, step: int) -> np.ndarray:
        values[0], values[-1] = ends[0][step], ends[1][step]
        return values

    steady = held(np.full(POINTS, sink * room), 0)
    now = solve_banded((1, 1), banded(2 * spread + sink, -spread), steady)
    implicit = banded(1 + STEP * (spread + sink / 2), -STEP * spread / 2)
    found = [now]
    for step in range(1, len(grid)):
        rate = np.zeros(POINTS)
        rate[1:-1] = spread * (now[2:] - 2 * now[1:-1] + now[:-2]) - sink * now[1:-1]
        wanted = held(now + STEP / 2 * rate + STEP * sink * room, step)
        now = solve_banded((1, 1), implicit, wanted)
        found.append(now)
    couples = np.array(found)[:, BETWEEN:-1:BETWEEN]
    return np.stack([np.interp(time, grid, one) for one in couples.T], 1)


class Rod:
    """The record, and the residuals of what is asked of it."""

    def __init__(self, time: np.ndarray, read: np.ndarray) -> None:
        self.time, self.read = time, read[:, 1:7]
        self.grid = STEP * np.arange(int(time[-1] / STEP) + 1)
        self.ends = end_histories(time, read, self.grid)
        self.room = float(read[0].mean())

    def apart(self, values: np.ndarray, room: float, off: np.ndarray) -> np.ndarray:
        """Simulated less measured (frames, 6) [K]; the room and both ends are off by so much."""
        ends = (self.ends[0] + off[0], self.ends[1] + off[1])
        there = inner_couples(values[0], values[1], self.room + room, ends, self.grid, self.time)
        return there - self.read


def freed(rod: Rod, room: bool, ends: bool) -> tuple[np.ndarray, float, np.ndarray]:
    """Fit with the room and the ends let go or not: the values, the room [K], offsets [K]."""

    def parts(values: np.ndarray) -> tuple[float, np.ndarray]:
        return (values[2] if room else 0.0), (values[-2:] if ends else np.zeros(2))

    first = np.array([*FIRST, *[0.0] * (room + 2 * ends)])
    scale = np.array([1.0, 5.0, *[0.1] * (room + 2 * ends)])
    found = least_squares(lambda v: rod.apart(v, *parts(v)).ravel(), first, x_scale=scale).x
    return found, *parts(found)


def ends_freed(rod: Rod, room: float) -> tuple[np.ndarray, float, np.ndarray]:
    """Fit with the ends let go and the room so much [K] warmer than the rod at first."""
    scale = np.array([1.0, 5.0, 0.1, 0.1])
    first = np.array([*FIRST, 0.0, 0.0])
    found = least_squares(lambda v: rod.apart(v, room, v[2:]).ravel(), first, x_scale=scale).x
    return found, room, found[2:]


def believed(rod: Rod, couple: float, room: float) -> tuple[np.ndarray, float, np.ndarray]:
    """Fit with offsets of all couples, of deviation `couple` [K], and of the room, `room` [K]."""
    weigh = 1 / (RESOLUTION * np.sqrt(ALIKE))

    def residual(values: np.ndarray) -> np.ndarray:
        apart = rod.apart(values, values[2], values[3:5]) + values[5:]
        return np.concatenate([weigh * apart.ravel(), values[3:] / couple, [values[2] / room]])

    first = np.concatenate([FIRST, np.zeros(9)])
    scale = np.array([1.0, 5.0, *[0.1] * 9])
    found = least_squares(residual, first, x_scale=scale).x
    return found, float(found[2]), found[3:5]


def in_a_laboratory(rod: Rod, alike: int) -> tuple[np.ndarray, float, np.ndarray]:
    """Fit with the ends' offsets and a laboratory's room, where so many readings count as one."""
    weigh = 1 / (RESOLUTION * np.sqrt(alike))
    mean, deviation = LABORATORY

    def residual(values: np.ndarray) -> np.ndarray:
        apart = rod.apart(values, values[2], values[3:])
        room = (rod.room + values[2] - mean) / deviation
        return np.concatenate([weigh * apart.ravel(), values[3:] / OFF, [room]])

    scale = np.array([1.0, 5.0, 1.0, 0.1, 0.1])
    found = least_squares(residual, np.array([*FIRST, 0.0, 0.0, 0.0]), x_scale=scale)
    left = np.linalg.inv(found.jac.T @ found.jac)
    print(f"deviation of the diffusivity in the next line {np.sqrt(left[0, 0]):.2f} mm2/s")
    return found.x, float(found.x[2]), found.x[3:]


def set_right(rod: Rod) -> Rod:
    """The rod with what its inner couples are off in its first block taken off, by a fit's model.

    The steady state there follows from both ends alone but for the loss, which moves it little.
    """
    values, *let_go = freed(rod, False, False)
    off = rod.apart(values, *let_go)[:BLOCK].mean(0)
    other = copy(rod)
    other.read = rod.read + off
    return other


def line(rod: Rod, name: str, fit: Callable[[], tuple[np.ndarray, float, np.ndarray]]) -> list[str]:
    """One line of the table."""
    values, room, ends = fit()
    apart = rod.apart(values, room, ends)
    free = apart - apart.mean(0)
    numbers = (values[0], values[0] / TABLE, values[1], room, *ends)
    rms = [float(np.sqrt(np.mean(one**2))) for one in (apart, free)]
    return [name, *(f"{number:.3f}" for number in (*numbers, *rms))]


def main() -> None:
    """Fit, print and write the table."""
    given = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("THERMOFIELD_DATA")
    rod = Rod(*read_record(Path(given) if given else ROOT / "data"))
    rows = [["let go", "diffusivity_mm2_s", "over_sheet", "loss_W_m2_K", "room_K", "first_end_K",
             "last_end_K", "rmse_K", "rmse_free_K"]]  # fmt: skip
    asked: list[tuple[str, Callable[[], tuple[np.ndarray, float, np.ndarray]]]] = [
        ("nothing", lambda: freed(rod, False, False)),
        ("room", lambda: freed(rod, True, False)),
        ("ends", lambda: freed(rod, False, True)),
        ("room and ends", lambda: freed(rod, True, True)),
    ]
    for room in ROOMS:
        off = room - rod.room
        asked.append((f"ends, room at {room:g} C", lambda off=off: ends_freed(rod, off)))
    for couple in (0.05, 0.1, 0.2):
        for room in (0.1, 1.0, 3.0):
            name = f"all couples by {couple} K and room by {room} K"
            asked.append((name, lambda c=couple, r=room: believed(rod, c, r)))
    for said, alike in (("ten minutes", ALIKE), ("a couple's readings", len(rod.time))):
        name = f"ends by {OFF} K in a laboratory and {said} as one"
        asked.append((name, lambda alike=alike: in_a_laboratory(rod, alike)))
    for name, fit in asked:
        rows.append(line(rod, name, fit))
        print(*rows[-1], sep="  ", flush=True)
    rested = set_right(rod)
    rows.append(line(rested, "couples set right at rest", lambda: freed(rested, False, False)))
    print(*rows[-1], sep="  ", flush=True)
    with RESULTS.open("w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    main()

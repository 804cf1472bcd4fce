"""What is missing in a model of a copper plate, or of an insulation board, under a radiant panel.

    python examples/nist_gasification.py copper|insulation [DATA_FOLDER] [--out FOLDER]

The measurements are NIST's (Leventon and De Lannoye 2023, doi 10.18434/mds2-2940), means of three
tests in the gasification apparatus at 50 kW/m2. They are not in this repository: DATA_FOLDER, or
the environment variable THERMOFIELD_DATA, names the folder that holds measured/nist_gasification.

How they are made scenes:

- Couples lie near the axis of discs of 82.5 mm, far from the edge, so that the body is a column
  under the panel's middle whose sides are insulated. The panel is a lamp so wide that its flux is
  even, and its rise after the shutter opens is the stated one.
- The copper plate (3.175 mm, on fibre insulation, one couple at its back) is said to do nothing
  but absorb 0.92 of the flux: no convection, no radiation, and nothing lost behind.
- The insulation board has couples 5.72, 11.44 and 17.16 mm below its top. What the outer two read
  is prescribed, and the one between is compared with a conductivity that does not change.
- What a camera may do wrong is left out of the candidates, and for copper, which melts at 1358 K,
  a latent heat.
- Half the stated uncertainty, which is of two standard deviations, is the model error; in the
  insulation with half of that of each outer couple beside the middle one's own, as at rest between
  them it reads their mean.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from asking import CAMERA, tell, without
from steel_rod import data_folder

import thermo
from thermo.discover import Verdict, discover
from thermo.discover.candidates import LatentHeat
from thermo.inverse import Meshing, Stepping
from thermo.observe import (
    Box,
    Course,
    Heater,
    Prescribed,
    Recording,
    Run,
    StatedMaterial,
    write_scene,
)

RECORDS = Path("measured/nist_gasification")

FLUX = 50e3  # W/m2, on the middle
RISE = Course(
    [1.0, 9.0, 11.0, 59.0, 61.0, 119.0, 121.0], [0.9401, 0.9401, 0.9598, 0.9598, 0.9831, 0.9831, 1]
)
ABSORBED = 0.92
PLATE = 3.175e-3  # m
SIDE = 4e-3  # m, of the column
LAYER = 5.72e-3  # m, between couples


def read(folder: Path, name: str, columns: int) -> np.ndarray:
    """The table of a record, its rows of units left out: times [s], then temperatures [K]."""
    path = folder / RECORDS / name
    if not path.is_file():
        raise FileNotFoundError(
            f"the measurement is not at {path}\nname its folder: python "
            "examples/nist_gasification.py copper DATA_FOLDER, or set THERMOFIELD_DATA"
        )
    return np.loadtxt(path, delimiter=",", skiprows=2, usecols=range(columns))


def sides(height: float) -> Box:
    """All faces but the top and, where it lies at zero, the bottom [m]."""
    return Box([-1.0, -1.0, 1e-3 * height], [1.0, 1.0, 0.999 * height])


def column(path: Path, height: float) -> None:
    """A column of square section [m], from zero up."""
    body = trimesh.creation.box([SIDE, SIDE, height])
    body.apply_translation([0.0, 0.0, height / 2])
    body.export(path)


def copper(data: Path, out: Path) -> tuple[float, float]:
    """Write the scene of the copper plate. Returns readings' model error [K] and the time [s]."""
    table = read(data, "Black-Copper_q50_Temp.csv", 3)
    time, seen, doubt = table.T
    start = float(seen[0])
    panel = Heater(
        [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, ABSORBED * FLUX * SIDE**2, 1e6, 0.0, RISE
    )
    behind = Box([-1.0, -1.0, -1e-6], [1.0, 1.0, 1e-6])
    run = Run(
        name="panel", recording=Recording(np.zeros((1, 3)), time, seen[:, None]),
        initial_temperature=start, ambient_temperature=298.0, radiation_temperature=289.0,
        heater=panel, insulated=(sides(PLATE), behind),
    )  # fmt: skip
    surface = out.with_suffix(".ply")
    column(surface, PLATE)
    write_scene(out, thermo.Scene(
        folder=out, object="copper plate", surface_path=surface, unit="m",
        material=StatedMaterial("copper", 8940.0, 390.0, 390.0), convection=0.0, emissivity=0.0,
        unknown=("conductivity",), prior={"conductivity": 0.01}, runs={"panel": run},
    ))  # fmt: skip
    return float(np.mean(doubt)) / 2, float(time[-1])


def insulation(data: Path, out: Path) -> tuple[float, float]:
    """Write the scene of the insulation board. Returns as `copper` does."""
    table = read(data, "Black-Insulation_q50_Temp.csv", 7)
    time, above, middle, below, of_above, own, of_below = table.T
    height = 2 * LAYER
    whole = ([-1.0, -1.0], [1.0, 1.0])
    ends = tuple(
        Prescribed([*whole[0], at - 1e-5], [*whole[1], at + 1e-5], time, values)
        for at, values in ((height, above), (0.0, below))
    )
    start = float(middle[0])
    run = Run(
        name="panel",
        recording=Recording(np.array([[SIDE / 2, 0.0, LAYER]]), time, middle[:, None]),
        initial_temperature=start, ambient_temperature=start, radiation_temperature=start,
        prescribed=ends, insulated=(sides(height),),
    )  # fmt: skip
    surface = out.with_suffix(".ply")
    column(surface, height)
    write_scene(out, thermo.Scene(
        folder=out, object="insulation board", surface_path=surface, unit="m",
        material=StatedMaterial("Kaowool PM", 256.0, 1070.0, 0.06), convection=0.0, emissivity=0.0,
        unknown=("conductivity",), prior={}, runs={"panel": run},
    ))  # fmt: skip
    error = np.sqrt(np.mean(own**2 + (of_above**2 + of_below**2) / 4)) / 2
    return float(error), float(time[-1])


CASES: dict[str, Callable[[Path, Path], tuple[float, float]]] = {
    "copper": copper, "insulation": insulation,
}  # fmt: skip
CANDIDATES = {"copper": without(*CAMERA, LatentHeat), "insulation": without(*CAMERA)}


def run(case: str, data: Path, out: Path, say: Callable[[str], None] = print) -> Verdict:
    """Write the scene of a case below `out`, and ask what is missing."""
    out.mkdir(parents=True, exist_ok=True)
    error, _ = CASES[case](data, out / "scene")
    return discover(
        out / "scene", model_error=error, meshing=Meshing(max_nodes=1000), say=say,
        stepping=Stepping(most_frames=120), candidates=CANDIDATES[case],
    )  # fmt: skip


def main() -> None:
    """Ask, print, and leave the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=sorted(CASES))
    parser.add_argument("data", nargs="?", help="folder that holds measured/nist_gasification")
    parser.add_argument("--out", type=Path, default=Path("outputs/nist_gasification"))
    asked = parser.parse_args()
    out = asked.out / asked.case
    try:
        verdict = run(asked.case, data_folder(asked.data), out)
    except (FileNotFoundError, thermo.InputError) as fault:
        sys.exit(f"nist_gasification: {fault}")
    tell(verdict, asked.case, out)


if __name__ == "__main__":
    main()

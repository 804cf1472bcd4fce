"""What is missing in an opaque model of a PMMA slab under two radiant fluxes.

    python examples/capa_pmma.py [DATA_FOLDER] [--out FOLDER]

The measurements are the University of Maryland's (CAPA II, MaCFP, github.com/MaCFP/matl-db, MIT
licence): the temperature of the slab's back, seen by an infrared camera, at 25 and at 60 kW/m2.
They are not in this repository: DATA_FOLDER, or the environment variable THERMOFIELD_DATA, names
the folder that holds measured/umd_capa_pmma.

How they are made a scene:

- The slab, 5.8 mm thick and 70 mm wide, is a column of 2 mm below its middle whose sides are
  insulated, narrow so that cells are short; the panel is a lamp so wide that its flux is even. The
  flux is absorbed at the front, 0.96 of it.
- Only the first 150 s at 25 kW/m2 and 60 s at 60 kW/m2 are used, before the polymer decomposes.
- Exchange is as measured: at the front 8.6 W/m2/K with gas of 330 and of 365 K, at the back
  4 W/m2/K with air of 300 and of 303 K, stated as air of that side; an emissivity of 0.96 towards
  300 K at both.
- The slab starts as warm as its back first reads, where it reads the same for ten seconds.
- The heat capacity is stated as the university measured it by DSC, 8.33 T - 1390 J/kg/K below the
  glass transition at 395 K and 3.07 T + 851 above (MaCFP_PMMA_UMD.json); the conductivity is said
  not to change, and one is fitted to both runs.
- A latent heat is left out of the candidates: in the heat capacity as measured it would show.
- What a model without faults would still be wrong by is put at half of what is stated for the
  readings, two standard deviations of the mean of twelve points: 0.64 K at 25 and 0.68 K at
  60 kW/m2, root mean squares of the column over the seconds that are used. Steps are planned for
  errors of 0.05 K each, a thirteenth of that.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from asking import tell, without
from steel_rod import data_folder

import thermo
from thermo.discover import Verdict, discover
from thermo.discover.candidates import LatentHeat
from thermo.inverse import Meshing, Stepping
from thermo.observe import (
    Air,
    Box,
    Heater,
    Recording,
    Run,
    StatedMaterial,
    TemperatureTable,
    write_scene,
)

RECORDS = Path("measured/umd_capa_pmma")

ABSORBED = 0.96
FRONT, BACK = 8.6, 4.0  # W/m2/K
ROOM = 300.0  # K
THICKNESS, SIDE = 5.8e-3, 2e-3  # m
DENSITY, FIRST_GUESS = 1210.0, 0.2
CAPACITY = TemperatureTable(  # K, J/kg/K
    (280.0, 395.0, 395.001, 560.0),
    (8.33 * 280 - 1390, 8.33 * 395 - 1390, 3.07 * 395 + 851, 3.07 * 560 + 851),
)
MODEL_ERROR = 0.65  # K
TOLERANCE = 0.05  # K, of a step
CANDIDATES = without(LatentHeat)
# By flux [kW/m2]: how long [s], gas before the front and air behind the back [K].
TESTS = {25: (150.0, 330.0, 300.0), 60: (60.0, 365.0, 303.0)}


def read(folder: Path, flux: int, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (frames,) [s], about one a second, and temperatures of the back (frames,) [K]."""
    path = folder / RECORDS / f"UMD_CAPA_{flux}kW_Temp.csv"
    if not path.is_file():
        raise FileNotFoundError(
            f"the measurement is not at {path}\nname its folder: "
            "python examples/capa_pmma.py DATA_FOLDER, or set THERMOFIELD_DATA"
        )
    table = np.genfromtxt(path, delimiter=",", skip_header=2)[:, [0, 2]]
    table = table[table[:, 0] <= end]
    every = max(round(1.0 / float(np.median(np.diff(table[:, 0])))), 1)
    return table[::every, 0], table[::every, 1]


def test_of(data: Path, flux: int) -> Run:
    """One test, its flux [kW/m2] as a lamp."""
    end, gas, behind = TESTS[flux]
    time, seen = read(data, flux, end)
    power = ABSORBED * 1e3 * flux * SIDE**2
    sides = Box([-1.0, -1.0, 1e-3 * THICKNESS], [1.0, 1.0, 0.999 * THICKNESS])
    return Run(
        name=f"flux_{flux}", recording=Recording(np.zeros((1, 3)), time, seen[:, None]),
        initial_temperature=float(seen[0]), ambient_temperature=gas, radiation_temperature=ROOM,
        heater=Heater([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, power, 1e6, 0.0), insulated=(sides,),
        air=(Air(Box([-1.0, -1.0, -1.0], [1.0, 1.0, 1e-3 * THICKNESS]), BACK, behind),),
    )  # fmt: skip


def write_slab(data: Path, out: Path) -> None:
    """Write the scene folder of the slab."""
    runs = {one.name: one for one in (test_of(data, flux) for flux in TESTS)}
    surface = out.with_suffix(".ply")
    body = trimesh.creation.box([SIDE, SIDE, THICKNESS])
    body.apply_translation([0.0, 0.0, THICKNESS / 2])
    body.export(surface)
    write_scene(out, thermo.Scene(
        folder=out, object="PMMA slab", surface_path=surface, unit="m",
        material=StatedMaterial("PMMA", DENSITY, CAPACITY, FIRST_GUESS), convection=FRONT,
        emissivity=ABSORBED, unknown=("conductivity",), prior={}, runs=runs,
    ))  # fmt: skip


def run(
    data: Path, out: Path, runs: tuple[str, ...] | None, say: Callable[[str], None] = print
) -> Verdict:
    """Write the scene below `out`, and ask what is missing in some runs, or in both."""
    out.mkdir(parents=True, exist_ok=True)
    write_slab(data, out / "scene")
    return discover(
        out / "scene", runs=runs, model_error=MODEL_ERROR, meshing=Meshing(max_nodes=4000), say=say,
        stepping=Stepping(most_frames=150, tolerance=TOLERANCE), candidates=CANDIDATES,
    )  # fmt: skip


def main() -> None:
    """Ask, print, and leave the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", nargs="?", help="folder that holds measured/umd_capa_pmma")
    parser.add_argument("--out", type=Path, default=Path("outputs/capa_pmma"))
    parser.add_argument("--run", choices=[f"flux_{flux}" for flux in TESTS], help="that one alone")
    asked = parser.parse_args()
    try:
        runs = (asked.run,) if asked.run else None
        verdict = run(data_folder(asked.data), asked.out, runs)
    except (FileNotFoundError, thermo.InputError) as fault:
        sys.exit(f"capa_pmma: {fault}")
    tell(verdict, "PMMA slab", asked.out)


if __name__ == "__main__":
    main()

"""Diffusivity of a real steel rod from eight thermocouples.

    python examples/steel_rod.py [DATA_FOLDER] [--out FOLDER] [--figure FILE]

The measurement: one end of a stainless steel rod (T-303, 25.4 mm thick) is heated and the other
is cooled, in an insulated case, with a thermocouple every 12.7 mm (University of Colorado Boulder,
teaching laboratory ASEN 3113). It carries no licence, so it is not in this repository: DATA_FOLDER,
or the environment variable THERMOFIELD_DATA, names the folder that holds
measured/cu_boulder_rods/2019_Steel_20V_185mA.txt.

How it is made a scene:

- The body is the rod between the couples TC1 and TC8. What they read is prescribed on its two end
  faces, so that neither the heater nor the cooler needs a model. The six couples in between are
  the samples. They are put on the side of the rod; with h R / k = 0.003 the temperature hardly
  varies across it.
- A scene starts at one temperature all over, and the rod does not: it reads 17.6 C at TC1 to
  19.5 C at TC8, almost a straight line, for the cooler is on already. So the scene starts LEAD
  seconds before the record, with both ends held at their first readings. The slowest part of the
  start decays as exp(-pi^2 alpha t / L^2), with a time constant of about 200 s, so that nothing is
  left of it when the record begins, and the rod is in the steady state that the record shows.
- The side loses heat through the insulation to the room. The loss is fitted as a convection
  coefficient with the room at the rod's mean temperature at the start, the one thing in the record
  that tells of the room; nobody logged it. The emissivity is 0: in the insulation there is no free
  surface, and what radiation there is belongs to the fitted coefficient.
- density and heat capacity are the laboratory sheet's for T-303. The diffusivity does not depend
  on them, the convection coefficient is proportional to their product.
- The couples resolve 0.1 K, which is the model error of the fit. A reading that flickers between
  two tenths would make the planned steps follow each flicker of the ends, so what is prescribed
  there are means over BLOCK readings, two minutes; the samples stay as they were read.

Three fits: the couples as read; with a constant taken off each of the six; and with the ends set
right. The last one's reasons: the couples at the ends are no better than the other six, which are
off by up to 0.2 K each, and at rest heat flows from the room into the rod, as its bend shows, so
that the room was warmer than the rod. So both ends may be off by a constant (OFF) and the room is a
laboratory's (ROOM). What is left in the end is constant couple by couple, so a couple's readings
count as one there: beside so little, what is believed of ends and room weighs much, and they leave
the diffusivity open by a sixth. The third fit takes no constant off the six.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh

import thermo
from thermo.inverse import LevenbergMarquardt, Meshing, Stepping, Uniform, summary
from thermo.observe import Prescribed, Recording, Run, StatedMaterial, write_scene

ROOT = Path(__file__).resolve().parents[1]
RECORD = Path("measured/cu_boulder_rods/2019_Steel_20V_185mA.txt")

RADIUS = 0.0127  # m
SPACING = 0.0127  # m, between couples
LENGTH = 7 * SPACING  # m, TC1 to TC8
LEAD = 3000.0  # s, before the record
TABLE = 4.05e-6  # m2/s, T-303 on the laboratory sheet
FIRST_GUESS = 10.0  # W/m/K, some steel; 38 % below the sheet
RESOLUTION = 0.1  # K
BLOCK = 12  # readings, 120 s
KELVIN = 273.15
ROOM = (22.0 + KELVIN, 3.0)  # K, a laboratory and its deviation
OFF = 0.3  # K, deviation of a couple at an end from what is there
TRIED = (5.0, 0.3, 0.3)  # K, by which room and ends are moved to see what that does


@dataclass(frozen=True)
class Result:
    """What the fit says: one number each, and the curves behind them."""

    diffusivity: float  # m2/s
    convection: float  # W/m2/K
    rmse: float  # K
    rmse_free: float  # K, one constant a couple taken off
    offset: np.ndarray  # (6,) K, measured less simulated
    time: np.ndarray  # (frames,) s, since the record began
    measured: np.ndarray  # (frames, 6) K
    simulated: np.ndarray  # (frames, 6) K

    def apart(self) -> np.ndarray:
        """Measured less simulated, (frames, 6) [K]."""
        return self.measured - self.simulated


@dataclass(frozen=True)
class Surroundings:
    """What nobody logged: the room, and what the couples at both ends are off by [K]."""

    room: float
    first: float = 0.0
    last: float = 0.0


def as_read(temperature: np.ndarray) -> Surroundings:
    """A room as warm as the rod at first, and ends as their couples read [K]."""
    return Surroundings(float(temperature[0].mean()))


def data_folder(given: str | None) -> Path:
    """The folder named by the argument, the environment or the default."""
    named = given or os.environ.get("THERMOFIELD_DATA")
    return Path(named) if named else ROOT / "data"


def read_record(folder: Path, record: Path = RECORD) -> tuple[np.ndarray, np.ndarray]:
    """Times (frames,) [s] and temperatures (frames, 8) [K] of TC1 to TC8."""
    path = folder / record
    if not path.is_file():
        raise FileNotFoundError(
            f"the measurement is not at {path}\n"
            "name its folder: python examples/steel_rod.py DATA_FOLDER, or set THERMOFIELD_DATA"
        )
    lines = [line for line in path.read_text("utf-8").splitlines() if len(line.split()) > 8]
    table = np.loadtxt(lines[1:], usecols=range(9))
    return table[:, 0], table[:, 1:] + KELVIN


def end_history(time: np.ndarray, temperature: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] of the scene and temperatures [K] of one end: the lead, then means of blocks."""
    whole = len(time) // BLOCK * BLOCK
    middle = time[:whole].reshape(-1, BLOCK).mean(axis=1)
    mean = temperature[:whole].reshape(-1, BLOCK).mean(axis=1)
    last = temperature[whole:] if whole < len(time) else temperature[-BLOCK:]
    stamps = np.concatenate([[0.0, LEAD], middle + LEAD, [time[-1] + LEAD]])
    values = np.concatenate([[temperature[0]] * 2, mean, [last.mean()]])
    return stamps, values


STEEL = StatedMaterial("stainless steel T-303", 8000.0, 500.0, FIRST_GUESS)
LOSS = 5.0  # W/m2/K, a first guess


def write_rod(
    folder: Path,
    time: np.ndarray,
    temperature: np.ndarray,
    material: StatedMaterial = STEEL,
    convection: float = LOSS,
    unknown: tuple[str, ...] = ("diffusivity", "convection"),
    constant_error: float = 0.0,
    around: Surroundings | None = None,
) -> None:
    """Write the scene folder of a rod whose couples may each be off by a constant [K].

    `around`: the room and what the ends are off by, `as_read` where left out.
    """
    around = as_read(temperature) if around is None else around
    room = around.room
    height = SPACING * np.arange(1, 7)
    points = np.stack([np.full(6, RADIUS), np.zeros(6), height], axis=1)
    ends = []
    for place, couple, off in ((0.0, 0, around.first), (LENGTH, 7, around.last)):
        # Thicker than what the mesh may lie off the surface.
        low, high = place - 3e-4, place + 3e-4
        ends.append(
            Prescribed(
                [-1.1 * RADIUS, -1.1 * RADIUS, low],
                [1.1 * RADIUS, 1.1 * RADIUS, high],
                *end_history(time, temperature[:, couple] - off),
            )
        )
    run = Run(
        name="heating",
        recording=Recording(points, time + LEAD, temperature[:, 1:7]),
        initial_temperature=float(temperature[0].mean()),
        ambient_temperature=room,
        radiation_temperature=room,
        prescribed=tuple(ends),
        constant_error=constant_error,
    )
    with tempfile.TemporaryDirectory() as name:
        surface = Path(name) / "surface.ply"
        rod = trimesh.creation.cylinder(radius=RADIUS, height=LENGTH, sections=48)
        rod.apply_translation([0.0, 0.0, LENGTH / 2])
        rod.export(surface)
        scene = thermo.Scene(
            folder=Path(name),
            object=f"{material.name} rod",
            surface_path=surface,
            unit="m",
            material=material,
            convection=convection,
            emissivity=0.0,
            unknown=unknown,
            prior={},
            runs={"heating": run},
        )
        write_scene(folder, scene)


def without_offsets(scene: thermo.Scene, offset: np.ndarray) -> thermo.Scene:
    """The scene with a constant [K] taken off each couple."""
    run = scene.runs["heating"]
    record = run.recording
    corrected = Recording(record.points, record.time, record.temperature - offset)
    return replace(scene, runs={"heating": replace(run, recording=corrected)})


def fit(scene: thermo.Scene) -> Result:
    """Fit diffusivity and side loss together."""
    estimate = thermo.invert(
        scene,
        choice=Uniform(),
        optimiser=LevenbergMarquardt(),
        stepping=Stepping(most_frames=300, tolerance=0.02),
        meshing=Meshing(order=2, max_nodes=3000),
        model_error=RESOLUTION,
    )
    run = estimate.runs["heating"]
    rest = run.measured - run.simulated
    offset = rest.mean(axis=0)

    def value(name: str) -> float:
        return float(summary(estimate.mesh, estimate.fields[name])["median"])

    return Result(
        diffusivity=value("diffusivity"),
        convection=value("convection"),
        rmse=run.rmse,
        rmse_free=float(np.sqrt(np.mean((rest - offset) ** 2))),
        offset=offset,
        time=run.time - LEAD,
        measured=run.measured,
        simulated=run.simulated,
    )


def set_right(
    fitted: Callable[[Surroundings], Result], read: Surroundings, plain: Result
) -> Surroundings:
    """The room and the ends of which the fit and what is believed of them are most likely together.

    By Gauss-Newton steps over fits: each is the best one under its surroundings, and what that
    leaves is all but linear in them. `plain` is the fit under those that were `read`.
    """
    first = np.array([read.room, 0.0, 0.0])
    moved = [fitted(Surroundings(*(first + step))).apart() for step in np.diag(TRIED)]
    weigh = 1 / (RESOLUTION * np.sqrt(len(plain.time)))
    slopes = np.stack([one - plain.apart() for one in moved], -1) / np.array(TRIED)
    spread, middle = np.array([ROOM[1], OFF, OFF]), np.array([ROOM[0], 0.0, 0.0])
    matrix = np.vstack([weigh * slopes.reshape(-1, 3), np.diag(1 / spread)])
    here, left = first, plain.apart()
    for last in (False, True):
        sides = np.concatenate([-weigh * left.ravel(), (middle - here) / spread])
        here = here + np.linalg.lstsq(matrix, sides, rcond=None)[0]
        if not last:
            left = fitted(Surroundings(*here)).apart()
    return Surroundings(*here)


def draw(path: Path, result: Result) -> None:
    """Measured and simulated curves of the six inner couples, and their differences."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(
        2, 1, figsize=(7, 6), sharex=True, height_ratios=(2, 1), layout="constrained"
    )
    hours = result.time / 3600
    for couple in range(6):
        colour = pyplot.get_cmap("viridis")(couple / 6)
        label = f"TC{couple + 2}"
        above.plot(hours, result.measured[:, couple] - KELVIN, ".", ms=4, color=colour, label=label)
        above.plot(hours, result.simulated[:, couple] - KELVIN, "-", lw=1, color=colour)
        below.plot(
            hours, result.measured[:, couple] - result.simulated[:, couple], lw=1, color=colour
        )
    above.set_ylabel("temperature [°C]")
    above.legend(ncols=2, fontsize=8, title="points measured, lines fitted", title_fontsize=8)
    above.set_title(
        f"Steel rod: diffusivity {result.diffusivity * 1e6:.2f} mm²/s "
        f"(sheet {TABLE * 1e6:.2f}), side loss {result.convection:.1f} W/m²/K"
    )
    below.axhline(0, color="0.7", lw=0.8)
    below.set_ylabel("measured − fitted [K]")
    below.set_xlabel("time [h]")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    pyplot.close(figure)


def print_table(results: tuple[Result, Result, Result], around: Surroundings) -> None:
    """The numbers of all fits."""
    plain = results[0]
    print(f"{'':34}{'as read':>12}{'offsets off':>12}{'ends right':>12}")
    for label, scale, form, name in (
        ("diffusivity [mm2/s]", 1e6, ".3f", "diffusivity"),
        ("side loss [W/m2/K]", 1.0, ".2f", "convection"),
        ("RMSE of the six couples [K]", 1.0, ".3f", "rmse"),
        ("RMSE less one constant a couple", 1.0, ".3f", "rmse_free"),
        ("diffusivity / sheet", 1 / TABLE, ".3f", "diffusivity"),
    ):
        numbers = [scale * getattr(result, name) for result in results]
        print(f"{label:34}" + "".join(f"{number:12{form}}" for number in numbers))
    named = ", ".join(f"TC{n + 2} {value:+.2f}" for n, value in enumerate(plain.offset))
    print(f"mean of measured - fitted, as read [K]: {named}")
    room, off = around.room - KELVIN, f"TC1 {around.first:+.2f}, TC8 {around.last:+.2f}"
    print(f"with the ends right: a room of {room:.1f} C; read too much by [K]: {off}")


def run(data: Path, out: Path) -> tuple[tuple[Result, Result, Result], Surroundings]:
    """Write the scene folder `out`, fit it in the three ways; room and ends of the third."""
    time, temperature = read_record(data)

    def scene_under(around: Surroundings, folder: Path) -> thermo.Scene:
        write_rod(folder, time, temperature, around=around)
        return thermo.read_scene(folder)

    read = as_read(temperature)
    scene = scene_under(read, out)
    plain = fit(scene)
    with tempfile.TemporaryDirectory() as name:
        around = set_right(lambda one: fit(scene_under(one, Path(name))), read, plain)
    right = fit(scene_under(around, out.with_name(f"{out.name}_ends_right")))
    return (plain, fit(without_offsets(scene, plain.offset)), right), around


def main() -> None:
    """Fit, print and draw."""
    parser = argparse.ArgumentParser(description="Diffusivity of a steel rod from thermocouples.")
    parser.add_argument("data", nargs="?", help="folder that holds measured/cu_boulder_rods")
    parser.add_argument("--out", type=Path, default=Path("outputs/steel_rod/scene"))
    parser.add_argument("--figure", type=Path, default=Path("outputs/steel_rod/steel_rod.png"))
    arguments = parser.parse_args()
    try:
        results, around = run(data_folder(arguments.data), arguments.out)
    except (FileNotFoundError, thermo.InputError) as fault:
        sys.exit(f"steel_rod: {fault}")
    print_table(results, around)
    draw(arguments.figure, results[2])
    print(f"scene: {arguments.out}\nfigure: {arguments.figure}")


if __name__ == "__main__":
    main()

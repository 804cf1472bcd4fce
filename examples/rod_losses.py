"""What is missing in a model of a heated rod that is said to lose nothing through its side.

    python examples/rod_losses.py steel|aluminium|brass [DATA_FOLDER] [--out FOLDER]

The measurements and how they are made a scene are those of `steel_rod.py`: eight couples along a
rod in an insulated case, the outer two prescribed on its ends. Here the side is said to lose
nothing, and the diffusivity alone is unknown. Each couple may be off by a constant of 0.3 K, which
is what the couples of this rig are seen to differ by; what the ends are held at is known to half a
tenth, which is the model error. What a camera may do wrong is left out of the candidates.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from asking import CAMERA, tell, without
from steel_rod import data_folder, read_record, write_rod

import thermo
from thermo.discover import Verdict, discover
from thermo.inverse import Meshing, Stepping
from thermo.observe import StatedMaterial

FOLDER = Path("measured/cu_boulder_rods")
RODS = {
    "steel": ("2019_Steel_20V_185mA.txt", StatedMaterial("T-303", 8000.0, 500.0, 16.2)),
    "aluminium": ("2019_Aluminum_25V_240mA.txt", StatedMaterial("7075-T651", 2810.0, 960.0, 130.0)),
    "brass": ("2019_Brass_30V_285mA.txt", StatedMaterial("C360", 8500.0, 380.0, 115.0)),
}
OFF = 0.3  # K, what a couple may be off by
ENDS = 0.05  # K, how well the ends are known


def run(rod: str, data: Path, out: Path, say: Callable[[str], None] = print) -> Verdict:
    """Write the scene of a rod below `out`, and ask what is missing."""
    name, material = RODS[rod]
    time, temperature = read_record(data, FOLDER / name)
    out.mkdir(parents=True, exist_ok=True)
    write_rod(out / "scene", time, temperature, material, 0.0, ("diffusivity",), OFF)
    return discover(
        out / "scene", model_error=ENDS, meshing=Meshing(max_nodes=3000), say=say,
        stepping=Stepping(most_frames=150, tolerance=0.02), candidates=without(*CAMERA),
    )  # fmt: skip


def main() -> None:
    """Ask, print, and leave the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rod", choices=sorted(RODS))
    parser.add_argument("data", nargs="?", help="folder that holds measured/cu_boulder_rods")
    parser.add_argument("--out", type=Path, default=Path("outputs/rod_losses"))
    asked = parser.parse_args()
    out = asked.out / asked.rod
    try:
        verdict = run(asked.rod, data_folder(asked.data), out)
    except (FileNotFoundError, thermo.InputError) as fault:
        sys.exit(f"rod_losses: {fault}")
    tell(verdict, f"{asked.rod} rod", out)


if __name__ == "__main__":
    main()

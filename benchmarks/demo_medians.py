"""How well `make demo` recovered the bracket: medians of plate and wall, error of the prediction.

    make demo && python benchmarks/demo_medians.py

The bracket is a plate of 1.0 W/m/K and a wall of 4.0 W/m/K; the medians are over the surface
points of `field.npz` at x > -0.016 m and x < -0.022 m.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

DEMO = Path(__file__).resolve().parents[1] / "outputs" / "demo"


def main() -> None:
    """Print what the demo left."""
    if not (DEMO / "predict" / "result.json").is_file():
        sys.exit(f"no results in {DEMO}: run `make demo` first")
    with (DEMO / "invert" / "field.npz").open("rb") as stream, np.load(stream) as stored:
        x, field = stored["points"][:, 0], stored["conductivity"]
    for name, part, truth in (("plate", x > -0.016, 1.0), ("wall", x < -0.022, 4.0)):
        middle = float(np.median(field[part]))
        print(f"{name}: {middle:.3f} W/m/K, {100 * (middle / truth - 1):+.1f} % of {truth}")
    fit = json.loads((DEMO / "invert" / "result.json").read_text())
    told = json.loads((DEMO / "predict" / "result.json").read_text())
    for name, rmse in fit["fit"]["rmse"].items():
        print(f"fitted {name}: RMSE {rmse:.3f} K")
    for name, scores in told["scores"].items():
        print(f"held out {name}: RMSE {scores['spatial']['rmse']:.3f} K, noise 0.058 K")
    print(f"{fit['seconds'] + told['seconds']:.0f} s in all, without starting Python")


if __name__ == "__main__":
    main()

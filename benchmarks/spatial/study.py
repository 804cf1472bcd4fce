"""Recovery of conductivities that truly vary.

    python benchmarks/spatial/scenes.py FOLDER
    python benchmarks/spatial/study.py FOLDER [--table FILE] [--figures DIR]

Fits the plate and the rod with the default settings, predicts the held-out lamp, and compares with
the truth on the faces of the fit's mesh. `uniform` is the error of the best single value.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
from scenes import patchy, smooth

import thermo
from thermo.inverse import Estimate, field_scores
from thermo.mesh import face_areas, face_centres
from thermo.report import figure_field

LAWS = {"plate": smooth, "rod": patchy}
HEADER = ("object", "error", "uniform", "width", "correlation", "step",
          "held_out_rmse_K", "median_rmse_K", "worst_fit_rmse_K", "seconds")  # fmt: skip


def best_single(truth: np.ndarray, areas: np.ndarray) -> float:
    """The least mean relative error that one value for the body can have [1]."""
    tried = np.geomspace(truth.min(), truth.max(), 200)
    return min(float(np.average(np.abs(value / truth - 1), weights=areas)) for value in tried)


def row(name: str, folder: Path, estimate: Estimate) -> dict:
    """A line of the table."""
    field, mesh = estimate.fields["conductivity"], estimate.mesh
    truth, areas = LAWS[name](face_centres(mesh).T), face_areas(mesh)
    scores = field_scores(mesh, field, truth)
    (made,) = thermo.predict(folder, estimate).values()
    return {
        "object": name,
        "error": scores.error,
        "uniform": best_single(truth, areas),
        "width": scores.width,
        "correlation": float(np.corrcoef(np.log(field.faces), np.log(truth))[0, 1]),
        "step": estimate.smoothness["conductivity"],
        "held_out_rmse_K": made.scores["spatial"].rmse,
        "median_rmse_K": made.scores["median"].rmse,
        "worst_fit_rmse_K": max(run.rmse for run in estimate.runs.values()),
        "seconds": estimate.seconds,
    }


def main() -> None:
    """Fit both objects both ways."""
    parser = argparse.ArgumentParser(description="Recovery of conductivities that truly vary.")
    parser.add_argument("folder", type=Path, help="what scenes.py wrote")
    parser.add_argument("--table", type=Path, help="CSV file for the results")
    parser.add_argument("--figures", type=Path, help="folder for maps of field and error")
    given = parser.parse_args()
    rows = []
    for name, law in LAWS.items():
        folder = given.folder / name
        estimate = thermo.invert(folder)
        rows.append(row(name, folder, estimate))
        print(rows[-1], flush=True)
        if given.figures:
            mesh, faces = estimate.mesh, estimate.fields["conductivity"].faces
            truth = law(face_centres(mesh).T)
            for what, values, unit in (
                ("recovered", faces, "conductivity [W/m/K]"),
                ("error", np.abs(faces / truth - 1), "|recovered / true - 1|"),
            ):
                path = given.figures / f"{name}_{what}.png"
                figure_field(path, mesh.nodes, mesh.faces, values, what.capitalize(), unit)
    if given.table:
        with given.table.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, HEADER)
            writer.writeheader()
            writer.writerows(
                {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in one.items()}
                for one in rows
            )


if __name__ == "__main__":
    main()

"""How far predictions may be off, from draws of the fields that the data allow."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from jaxtyping import Float

from thermo._compiled import make_room
from thermo.errors import InputError
from thermo.inverse._field_posterior import FieldPosterior
from thermo.inverse._forward import temperatures
from thermo.inverse._properties import properties
from thermo.inverse._selection import select_runs
from thermo.observe import Scene, estimate_noise, read_scene

NORMAL = 1.959963984540054
"""Half-width of a 95 % interval of a normal distribution, in standard deviations [1]."""

_STEP_ERROR = 0.02
"""Error of a time step [K] in the simulations of draws, whose differences alone count."""


@final
@dataclass(frozen=True)
class Band:
    """What the fields leave open of the temperatures of one run.

    - `time` (frames,) [s]; `points` (samples, 3) [m].
    - `deviation`: of the simulated temperature about that of the estimate, (frames, samples) [K].
    - `inside`: share of the readings within the 95 % band of fields, noise and model error [1].
    """

    time: Float[np.ndarray, " frames"]
    points: Float[np.ndarray, "samples 3"]
    deviation: Float[np.ndarray, "frames samples"]
    inside: float


def bands(
    data: Scene | str | Path,
    left: FieldPosterior,
    *,
    runs: tuple[str, ...] | None = None,
    draws: int = 20,
    seed: int = 0,
    model_error: float = 0.01,
) -> dict[str, Band]:
    """Prediction bands of runs, by name, on the mesh of the fit.

    Each set of fields that `left` draws is simulated, radiation and all. With `draws` of them the
    size of a band is known to 1 / sqrt(2 draws), 16 % for twenty.

    Arguments:

    - `data`: the scene, or its folder; `left`: what `posterior` made of it.
    - `runs`: names; all that are held out by default.
    - `draws`: how many [1], with a `seed`; `model_error`: of the simulation itself [K].

    Raises `InputError` for unknown runs and for fewer than two draws.
    """
    if draws < 2:
        raise InputError(
            "a band takes several draws", where="draws", value=draws, limit="2 or more",
            remedy="leave it at 20",
        )  # fmt: skip
    make_room()
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    sizes = (len(left.mesh.cells), len(left.mesh.faces))
    values = [
        {name: (field.cell_values(), field.face_values()) for name, field in left.fields.items()},
        *(
            {name: (item.cells, item.faces) for name, item in drawn.items()}
            for drawn in left.draw(draws, seed=seed)
        ),
    ]
    bodies = {str(n): properties(left.stated, one, *sizes) for n, one in enumerate(values)}
    found = {}
    for run in select_runs(scene, runs, held_out=True):
        record, where = run.recording, f"{scene.folder}: runs.{run.name}.recording"
        middle, *drawn = temperatures(
            left.mesh, left.order, run, bodies, _STEP_ERROR, where
        ).values()
        deviation = np.sqrt(np.mean((np.stack(drawn) - middle) ** 2, axis=0))
        noise = estimate_noise(record).total()
        wide = NORMAL * np.sqrt(deviation**2 + noise**2 + model_error**2)
        inside = np.abs(record.temperature - middle)[record.valid] <= wide[record.valid]
        found[run.name] = Band(record.time, record.points, deviation, float(np.mean(inside)))
    return found

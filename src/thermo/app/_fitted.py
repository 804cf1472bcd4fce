"""What a finished fit was asked and what it found, from the folder that it left."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from thermo.errors import InputError
from thermo.inverse import ALL_BUT_UNIFORM, load_estimate
from thermo.mesh import read_surface
from thermo.observe import Scene

_ALIKE = 0.03
"""Relative difference of lengths [1] up to which bodies may be one: a mesh cuts curved sides."""

_LEVEL = 0.05
"""Chance [1] below which what a search left is more than noise: the level of the search."""


@final
@dataclass(frozen=True)
class Fitted:
    """`runs` and `unknown` of a fit, and `values` by quantity, what was stated or a median [SI].

    - `folder`: where it is; `settings`: those of `thermo invert`.
    - `unexplained`: its remarks on runs that it does not explain.
    - `varies`: whether its unknowns were fields and not one value each, and `uneven`: whether they
      came out as other than one value.
    - `corrected`: whether what its cells and steps make wrong was taken off; `dropped`: whether
      spikes were left out.
    """

    folder: Path
    runs: tuple[str, ...]
    unknown: tuple[str, ...]
    values: dict[str, float]
    settings: Mapping[str, Any]
    varies: bool
    uneven: bool
    corrected: bool
    dropped: bool
    unexplained: tuple[str, ...]


def read_fitted(folder: Path) -> Fitted:
    """The fit in a folder [SI].

    Raises `InputError` where there is no finished fit, or its record is damaged.
    """
    path = folder / "result.json"
    try:
        record = json.loads(path.read_text("utf-8"))
        return _fitted(folder, record)
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise InputError(
            "this is no finished fit",
            where=str(path),
            value=f"{type(fault).__name__}: {fault}",
            limit="the result.json that `thermo invert` writes last",
            remedy="give the `out` folder of a finished `thermo invert` as `estimate`",
        ) from fault


def unexplained_by(folder: Path) -> tuple[str, ...]:
    """Remarks of the fit in a folder on runs that it does not explain; none where none are left."""
    try:
        return _odd(json.loads((folder / "result.json").read_text("utf-8")))
    except (OSError, ValueError, KeyError, TypeError):
        return ()


def left_by_search(folder: Path) -> tuple[str, ...]:
    """What the search in a folder could not explain, in words; nothing where it explained all.

    A folder that holds no search tells nothing.
    """
    try:
        record = json.loads((folder / "verdict.json").read_text("utf-8"))
        unnamed = record["verdict"] == "none_of_mine"
        if not unnamed and record["p_value"]["with"] > _LEVEL:
            return ()
        rounds, closest = record["rounds"], ""
        left = rounds[-1]["rms_after"] if rounds else {}
        if unnamed and rounds:
            # What was not named is at work in no prediction.
            left = rounds[0]["rms_before"]
            names = ", ".join(one["best"].replace("_", " ") for one in rounds)
            closest = (
                f" This predicts what is stated, as fitted, without what came closest, {names}."
            )
        sizes = [f"{name} {left[name]:.3g} K at a noise of {noise:.3g} K"
                 for name, noise in record["noise"].items() if name in left]  # fmt: skip
    except (OSError, ValueError, KeyError, TypeError):
        return ()
    told = f" ({', '.join(sizes)})" if sizes else ""
    words = f"The search that this rests on left more than noise, which it cannot explain{told}."
    return (words + closest,)


def _odd(record: dict[str, Any]) -> tuple[str, ...]:
    return tuple(str(one) for one in record["remarks"] if "does not explain" in str(one))


def _fitted(folder: Path, record: dict[str, Any]) -> Fitted:
    if record["verb"] != "invert":
        raise ValueError(f"it is of thermo {record['verb']}")
    medians = {name: float(item["median"]) for name, item in record["fields"].items()}
    stated = record["configuration"]["initial"]
    given = {name: float(value) for name, value in stated.items() if value is not None}
    settings = record["configuration"]
    runs, varies = tuple(record["fit"]["rmse"]), settings["field"]["kind"] != "uniform"
    spreads = [float(item["p95"]) / float(item["p05"]) - 1 for item in record["fields"].values()]
    uneven = varies and max(spreads) > ALL_BUT_UNIFORM
    corrected = any(record["fit"].get("defect", {}).values())
    dropped = settings.get("drop_spikes") is True
    return Fitted(
        folder,
        runs,
        tuple(medians),
        given | medians,
        settings,
        varies,
        uneven,
        corrected,
        dropped,
        _odd(record),
    )


def check_same_body(folder: Path, scene: Scene) -> None:
    """Refuse a fit whose body is not of the size of the scene's surface [m].

    Raises `InputError`.
    """
    mesh, *_ = load_estimate(folder / "estimate.npz")
    surface = read_surface(scene.surface_path, unit=scene.unit)  # type: ignore[arg-type]
    fitted, there = (np.ptp(points, axis=0) for points in (mesh.nodes, surface.vertices))
    if not np.allclose(fitted, there, rtol=_ALIKE, atol=_ALIKE * float(there.max())):
        raise InputError(
            "this fit is of another body",
            where=str(folder / "estimate.npz"),
            value=f"{_size(fitted)} m",
            limit=f"the size of {scene.surface_path.name}, {_size(there)} m",
            remedy="give the scene that was fitted as `data`",
        )


def _size(lengths: np.ndarray) -> str:
    return " x ".join(f"{length:.4g}" for length in lengths)

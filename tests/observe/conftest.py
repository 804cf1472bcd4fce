"""A small synthetic scene in a temporary folder, and a check of what a refusal says."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError

TETRAHEDRON = (
    "OFF\n4 4 0\n0 0 0\n0.04 0 0\n0 0.04 0\n0 0 0.04\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
)


def arrays() -> dict[str, np.ndarray]:
    """Three samples, four frames, two quiet frames."""
    generator = np.random.default_rng(5)
    return {
        "points": np.array([[0.0, 0.0, 0.0], [0.04, 0.0, 0.0], [0.01, 0.01, 0.0]]),
        "time": np.array([0.0, 0.5, 1.0, 2.0]),
        "temperature": 300.0 + generator.normal(size=(4, 3)),
        "quiet": 295.0 + generator.normal(size=(2, 3)),
    }


def table() -> dict[str, Any]:
    """The `scene.json` of the synthetic scene, with every documented key."""
    run = {
        "recording": "lamp.npz",
        "initial_temperature": 295.15,
        "ambient_temperature": 294,
        "radiation_temperature": 293.15,
        "heater": {
            "kind": "spot",
            "centre": [0.0, 0.0, 0.02],
            "direction": [0, 0, -2],
            "radius": 0.01,
            "power": 2.0,
            "until": 30.0,
            "rise": 1.0,
            "course": {"time": [0.0, 10.0], "share": [0.9, 1]},
        },
        "insulated": [[[-1e-3, -1e-3, -1e-3], [0.05, 0.05, 1e-3]]],
        "air": [
            {
                "box": [[-1e-3, -1e-3, -1e-3], [0.05, 0.05, 1e-3]],
                "convection": 4,
                "temperature": 299,
            }
        ],
        "held_out": True,
        "prescribed": [
            {
                "box": [[-1e-3, -1e-3, -1e-3], [1e-3, 0.05, 0.05]],
                "time": [0.0, 1.0, 2.0],
                "temperature": [295.0, 296.0, 297.0],
            },
            {"box": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], "history": "end.csv"},
        ],
        "notes": "the lamp was warm",
    }
    cooling = {**run, "recording": "cooling.npz", "heater": None, "held_out": False}
    del cooling["prescribed"], cooling["insulated"], cooling["air"], cooling["notes"]
    return {
        "format": "thermofield-scene/1",
        "object": "tetrahedron",
        "surface": "surface.off",
        "unit": "m",
        "scale_deviation": 0.01,
        "material": {
            "name": "ABS",
            "density": 1030,
            "heat_capacity": 1440.0,
            "conductivity": None,
        },
        "surface_exchange": {"convection": 3.0, "emissivity": 0.92},
        "unknown": ["conductivity", "convection"],
        "prior": {"convection_relative_sd": 0.3},
        "runs": {"lamp": run, "cooling": cooling},
        "description": "synthetic",
        "truth": {"conductivity": 0.19},
    }


@pytest.fixture
def recorded() -> dict[str, np.ndarray]:
    """Arrays of a sound recording."""
    return arrays()


@pytest.fixture
def stated() -> dict[str, Any]:
    """Entries of a sound `scene.json`."""
    return table()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A sound scene folder."""
    (tmp_path / "surface.off").write_text(TETRAHEDRON)
    (tmp_path / "scene.json").write_text(json.dumps(table()))
    (tmp_path / "end.csv").write_text("time_min,temperature_C\n0,22\n1,23\n")
    for name in ("lamp", "cooling"):
        np.savez(tmp_path / f"{name}.npz", allow_pickle=False, **arrays())
    return tmp_path


@pytest.fixture
def refuses() -> Callable[..., InputError]:
    """Return a check that a call is refused with a message that says all it must."""

    def check(
        call: Callable[[], object], *, where: str, value: str, limit: str, remedy: str
    ) -> InputError:
        with pytest.raises(InputError) as caught:
            call()
        error = caught.value
        assert where in error.where
        assert value in str(error.value)
        assert limit in error.limit
        assert remedy in error.remedy
        lines = str(error).splitlines()
        assert len(lines) == 4, "the message fits one screen"
        assert all(0 < len(line) < 400 for line in lines)
        for part in (error.where, str(error.value), error.limit, error.remedy):
            assert part and part in str(error)
        return error

    return check

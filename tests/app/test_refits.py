"""What is fitted anew where runs have no quiet frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from thermo.app._refits import Wanted, refit
from thermo.inverse import Meshing, Stepping
from thermo.observe import Recording, read_scene


def test_noise_is_learnt_from_the_residual_and_hides_no_misfit(block: Path, tmp_path: Path) -> None:
    scene = read_scene(block)
    run = scene.runs["cooling"]
    old = run.recording
    # Sensors that are off by far more than their fluctuation, which second differences do not see.
    apart = 0.5 * np.random.default_rng(0).standard_normal(len(old.points))
    record = Recording(old.points, old.time, old.temperature + apart, old.valid, None)
    scene = replace(scene, runs={"cooling": replace(run, recording=record)})
    asked = {
        "runs": None, "unknown": ("convection",),
        "initial": {"conductivity": 0.8, "convection": 25.0},
        "meshing": Meshing(order=1, max_nodes=600, corrected=False, cache=tmp_path),
        "stepping": Stepping(tolerance=0.1),
    }  # fmt: skip
    found = refit(scene, asked, {}, 0.01, Wanted(600.0, (), 0, 0))
    noise = found.noise["cooling"].noise
    assert noise.offset == pytest.approx(0.5, rel=0.4) and noise.white < 0.1
    # Against the noise that second differences show they are a misfit.
    assert found.misfit is not None and found.misfit > 5
    assert found.profiles["convection"].kind == "bounded"

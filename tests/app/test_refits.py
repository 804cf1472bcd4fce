"""What is fitted anew where runs have no quiet frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from thermo.app._refits import Wanted, refit
from thermo.inverse import Meshing, Stepping
from thermo.observe import Recording, read_scene

pytestmark = pytest.mark.usefixtures("bricks")


def test_noise_is_learnt_from_the_residual_and_hides_no_misfit(block: Path, tmp_path: Path) -> None:
    scene = read_scene(block)
    run = scene.runs["cooling"]
    old = run.recording
    # Sensors that are off by far more than their fluctuation, which second differences do not see,
    # and than what so coarse a mesh makes wrong. The median of 24 pairs tells a spread to a quarter
    # only: in this draw it is off by 2 %.
    apart = 2.0 * np.random.default_rng(2).standard_normal(len(old.points))
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
    assert noise.offset == pytest.approx(2.0, rel=0.2) and noise.white < 0.1
    # Against the noise that second differences show they are a misfit.
    assert found.misfit is not None and found.misfit > 5
    assert found.profiles["convection"].kind == "bounded"


def test_a_fit_is_left_when_its_time_is_spent(
    block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {
        "runs": ("cooling",), "unknown": ("convection",), "initial": {"conductivity": 0.8},
        "meshing": Meshing(order=1, max_nodes=600, corrected=False, cache=tmp_path),
        "stepping": Stepping(tolerance=0.1),
    }  # fmt: skip
    hours = iter(range(10))
    clock = SimpleNamespace(monotonic=lambda: 3600.0 * next(hours))
    monkeypatch.setattr("thermo.app._time_limit.time", clock)
    # The second simulation of the profile would begin after an hour and a half.
    found = refit(read_scene(block), asked, {}, 0.01, Wanted(5400.0, (3.0,), 0, 0))
    assert found.basins is None and found.profiles == {}
    late = [one for one in found.left_out if "did not suffice" in one]
    assert [one.split(" (")[0] for one in late] == [
        "Profiles of convection: 5400 s did not suffice", "Basins: 5400 s did not suffice",
    ]  # fmt: skip
    assert all("simulations made: 1," in one for one in late)

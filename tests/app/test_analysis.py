"""What an analysis allows for beside the noise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from thermo.app._analysis import allowing, first_guesses, learnt, whole_frames
from thermo.inverse import DEFECT_SPREAD, Sensitivity
from thermo.observe import Noise, ResidualNoise, read_scene


@pytest.mark.parametrize(("corrected", "left"), [(True, DEFECT_SPREAD), (False, 1.0)])
def test_a_corrected_fit_leaves_a_share_of_what_cells_and_steps_make_wrong(
    corrected: bool, left: float
) -> None:
    at = Sensitivity(("conductivity",), {"a": np.ones((5, 3, 1))}, {"a": 0.05}, values=(1.0,))
    # Measured over all frames of a longer run of the same kind.
    apart = np.random.default_rng(0).standard_normal((8, 3))
    made = allowing(at, {"a": apart}, corrected=corrected)
    assert np.allclose(made.defect["a"], left * apart[:5])


def test_what_a_residual_shows_makes_noise_wider_and_nothing_stated_narrower() -> None:
    at = Sensitivity(
        ("conductivity",), {"a": np.ones((5, 3, 1)), "b": np.ones((5, 3, 1))},
        {"a": 0.05, "b": 0.05}, staying={"a": 0.3, "b": 0.0}, values=(1.0,),
    )  # fmt: skip
    noise = Noise(0.1, 0.2, 0.5)
    made = learnt(at, {"a": ResidualNoise(noise, 0.0, 0.0, 1e-3)})
    assert made.noise == {"a": pytest.approx(0.1 * np.sqrt(3)), "b": 0.05}
    assert made.staying == {"a": 0.3, "b": 0.0}
    more = learnt(at, {"b": ResidualNoise(noise, 0.0, 0.0, 1e-3)})
    assert more.staying == {"a": 0.3, "b": 0.2}


def test_whole_frames_that_are_off_together_are_told_of() -> None:
    at = Sensitivity(("conductivity",), {"a": np.ones((5, 3, 1))}, {"a": 0.05}, values=(1.0,))
    assert whole_frames(at) == []
    (said,) = whole_frames(replace(at, common={"a": (0.034, 0.01), "b": (0.0, 0.0)}))
    assert said.startswith("Whole frames are off together, by 0.034 K in a; ")


def test_a_value_of_which_nothing_is_stated_is_told_to_be_a_guess(block: Path) -> None:
    scene = read_scene(block)
    names = ("conductivity", "convection", "volumetric_heat_capacity", "heater_power")
    unknown = replace(scene, convection=None, unknown=("conductivity", "convection"))
    (said,) = first_guesses(unknown, {"convection": None}, names)
    assert said.startswith("Nothing is stated of convection") and "initial.convection=" in said
    assert first_guesses(unknown, {"convection": 12.0}, names) == []
    assert first_guesses(scene, {}, names) == []
    bare = replace(scene, material=replace(scene.material, conductivity=None))
    assert len(first_guesses(bare, {}, ("diffusivity", "scaled_emissivity"))) == 1
    assert first_guesses(bare, {"conductivity": 2.0}, ("diffusivity",)) == []

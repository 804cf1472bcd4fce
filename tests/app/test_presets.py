"""Presets: the command's are those of the studies, and any setting of theirs can be changed."""

from __future__ import annotations

from typing import Any

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from thermo.app import _configuration as configuration
from thermo.app._command import configuration_folder
from thermo.inverse import LevenbergMarquardt, Uniform
from thermo.study import PRESETS


def settings(*words: str) -> dict[str, Any]:
    with initialize_config_dir(str(configuration_folder()), version_base="1.3"):
        made = OmegaConf.to_container(compose("invert", ["data=x", *words]), resolve=True)
    assert isinstance(made, dict)
    return {str(key): value for key, value in made.items()}


@pytest.mark.parametrize("name", ["best", "paper"])
def test_a_preset_of_the_command_is_that_of_the_studies(name: str) -> None:
    asked, preset = settings(f"preset={name}"), PRESETS[name]
    assert configuration.build_field(asked["field"]) == preset.choice
    assert configuration.build_optimiser(asked["optimiser"]) == preset.optimiser
    assert configuration.build_prior(asked["prior"]) == preset.prior
    assert configuration.build_stepping(asked["integrator"]) == preset.stepping
    assert configuration.build_meshing(asked["mesh"]) == preset.meshing


def test_the_best_one_is_the_default() -> None:
    assert settings() == settings("preset=best")


def test_what_is_given_counts_more_than_a_preset() -> None:
    asked = settings("preset=paper", "field=uniform", "optimiser=lm", "prior.step=0.1")
    assert configuration.build_field(asked["field"]) == Uniform()
    assert configuration.build_optimiser(asked["optimiser"]) == LevenbergMarquardt()
    assert configuration.build_prior(asked["prior"]).step == 0.1

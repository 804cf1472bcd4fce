"""What `thermo VERB --help` lists."""

from __future__ import annotations

import pytest
from omegaconf import OmegaConf

from thermo.app._command import VERBS, configuration_folder

from .conftest import Command

GROUPS = {one.name: one for one in configuration_folder().iterdir() if one.is_dir()}


@pytest.mark.parametrize("verb", VERBS)
def test_help_lists_the_groups_of_a_verb_and_no_other(verb: str, command: Command) -> None:
    words = ("paper", "--help") if verb == "study" else ("--help",)
    outcome = command(verb, *words)
    assert outcome.code == 0, outcome.err
    lines = [one.strip() for one in outcome.out.splitlines()]
    listed = {one.partition(": ")[0]: one.partition(": ")[2] for one in lines if ": " in one}
    file = OmegaConf.load(configuration_folder() / f"{verb}.yaml")
    assert OmegaConf.select(file, "hydra.mode") is None, "asked of the words alone in these tests"
    wanted = {name for one in file.defaults if not isinstance(one, str) for name in one}
    for group, folder in GROUPS.items():
        if group in wanted:
            options = {one.stem for one in folder.glob("*.yaml")}
            assert set(listed[group].split(", ")) == options
        else:
            assert group not in listed

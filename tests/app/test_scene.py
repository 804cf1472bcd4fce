"""The scene of a command: spikes stay unless they are asked to go, and nothing else is taken."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from thermo.app._scene import scene_of
from thermo.errors import InputError

from .conftest import SMALL, Command


@pytest.fixture
def spiky(own: Path) -> Path:
    """The block with one reading of its cooling 5 K off."""
    path = own / "cooling.npz"
    with np.load(path, allow_pickle=False) as stored:
        arrays = dict(stored)
    arrays["temperature"][14, 5] += 5.0
    np.savez(path, allow_pickle=False, **arrays)
    return own


def test_a_spike_goes_where_that_is_asked(spiky: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole, none = scene_of({"data": str(spiky), "drop_spikes": False})
    assert none == {} and whole.runs["cooling"].recording.valid[14, 5]
    for settings, drop in ((True, False), (False, True)):
        scene, dropped = scene_of({"data": str(spiky), "drop_spikes": settings}, drop=drop)
        assert dropped["cooling"] == 1 and not scene.runs["cooling"].recording.valid[14, 5]
        assert "1 in cooling" in capsys.readouterr().err


def test_what_is_neither_yes_nor_no_is_refused(block: Path) -> None:
    with pytest.raises(InputError) as caught:
        scene_of({"data": str(block), "drop_spikes": "often"})
    assert caught.value.where == "drop_spikes"


def test_a_fit_says_how_many_it_left_out(
    command: Command, spiky: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "fit"
    outcome = command(
        "invert", f"data={spiky}", f"out={out}", "drop_spikes=true", cache, *SMALL
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    found = json.loads((out / "result.json").read_text())
    assert found["fit"]["dropped"] == {"lamp": 0, "cooling": 1}

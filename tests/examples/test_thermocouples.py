"""The scene that the guide on thermocouples writes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from thermo.observe import read_scene

GUIDE = Path(__file__).parents[2] / "docs" / "thermocouples.md"


def test_the_guide_writes_a_scene_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (script,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text("utf-8"), re.S)
    monkeypatch.chdir(tmp_path)
    exec(compile(script, "thermocouples.md", "exec"), {})
    scene = read_scene(tmp_path / "bar")
    run = scene.runs["lamp"]
    assert scene.unknown == ("conductivity", "convection")
    assert run.recording.quiet is not None and run.recording.quiet.shape == (30, 5)
    (hot,) = run.prescribed
    # Nearer to the plate is warmer, and no couple is warmer than the plate.
    last = run.recording.temperature[-60:].mean(axis=0) - run.recording.quiet.mean(axis=0)
    assert np.all(np.diff(last) < 0) and last[0] < hot.temperature[-1] - 294.15

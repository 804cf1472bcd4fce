"""The installed console script, and a fit that is killed."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from .conftest import SMALL, Command

SCRIPT = Path(sysconfig.get_path("scripts")) / "thermo"

KILL = """
import os, signal, sys
from thermo.app import main
from thermo.report import Progress

def die(self, step, *_):
    if step == 2:
        os.kill(os.getpid(), signal.SIGKILL)

Progress.update = die
sys.argv = ["thermo", *sys.argv[1:]]
main()
"""


MISSING = "nowhere/scene.json: file not found\n"


def test_the_console_script_refuses_with_code_two(tmp_path: Path) -> None:
    ended = subprocess.run(
        [SCRIPT, "invert", "data=nowhere"], cwd=tmp_path, capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    assert ended.returncode == 2 and ended.stdout == ""
    assert ended.stderr.startswith(f"thermo invert: {MISSING}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [("predict", "estimate=nowhere"), ("simulate", "run=lamp")])
def test_a_scene_that_is_not_there_is_refused_by_each_verb(
    words: tuple[str, ...], command: Command
) -> None:
    # The script is the same for all verbs, so that it starts no process for these.
    outcome = command(*words, "data=nowhere")
    assert outcome.code == 2 and outcome.out == ""
    assert outcome.err.startswith(f"thermo {words[0]}: {MISSING}")
    assert list(Path.cwd().iterdir()) == []


LAUNCHERS = {"joblib": "joblib", "ray": "ray", "submitit_local": "submitit"}
"""Launchers of Hydra, and the package that each needs."""


@pytest.mark.parametrize("launcher", LAUNCHERS)
def test_a_launcher_runs_the_jobs_of_a_sweep(
    launcher: str, fit: Path, block: Path, cache: str, tmp_path: Path
) -> None:
    if find_spec(LAUNCHERS[launcher]) is None:
        pytest.skip(f"pip install '.[{LAUNCHERS[launcher]}]' for this launcher")
    # A folder that is not absolute must end up beside the command, whoever runs the job.
    words = ["-m", f"hydra/launcher={launcher}", f"data={block}", "out=sweep", cache]
    ended = subprocess.run(
        [SCRIPT, "invert", *words, *SMALL, "seed=0,1"], cwd=tmp_path, capture_output=True,
        text=True, timeout=500, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    wanted = json.loads((fit / "result.json").read_text())["fields"]
    for seed in (0, 1):
        found = json.loads((tmp_path / "sweep" / f"seed-{seed}" / "result.json").read_text())
        assert found["fields"] == wanted and found["configuration"]["seed"] == seed


@pytest.mark.usefixtures("unpictured")
def test_a_killed_fit_leaves_nothing_half_written_and_goes_on(
    fit: Path, command: Command, block: Path, cache: str, tmp_path: Path
) -> None:
    killed = tmp_path / "killed"
    words = ["invert", f"data={block}", cache, *SMALL]
    ended = subprocess.run(
        [sys.executable, "-c", KILL, *words, f"out={killed}"], cwd=tmp_path, capture_output=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, timeout=300, check=False,
    )  # fmt: skip
    assert ended.returncode == -9, ended.stderr.decode()
    assert [path.name for path in killed.iterdir()] == ["checkpoint.npz"]
    with np.load(killed / "checkpoint.npz", allow_pickle=False) as stored:
        assert len(stored["losses"]) == 2
    outcome = command(*words, f"out={killed}")
    assert outcome.code == 0, outcome.err
    mine, theirs = (json.loads((at / "result.json").read_text()) for at in (killed, fit))
    assert np.allclose(mine["fit"]["loss"], theirs["fit"]["loss"], rtol=1e-10, atol=0)
    assert len(mine["fit"]["loss"][0]) == 3
    for key in ("median", "p05", "p95"):
        wanted = theirs["fields"]["conductivity"][key]
        assert mine["fields"]["conductivity"][key] == pytest.approx(wanted, rel=1e-10)
    assert not (killed / "checkpoint.npz").exists()


def test_a_stopped_fit_says_how_to_go_on(
    command: Command, block: Path, cache: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from thermo.report import Progress

    def stop(self: Progress, *_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Progress, "update", stop)
    out = tmp_path / "out"
    outcome = command("invert", f"data={block}", cache, *SMALL, f"out={out}")
    assert outcome.code == 130 and "the same command goes on" in outcome.err
    assert [path.name for path in out.iterdir()] == ["checkpoint.npz"]


def test_a_verb_lets_the_collector_look_through_what_lives_seldom(command: Command) -> None:
    before = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    try:
        assert command("invert", "data=nowhere").code == 2
        assert gc.get_threshold()[0] > 10_000
    finally:
        gc.set_threshold(*before)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("invert", "datta=x"), "did you mean data?"),
        (("invert", "feild=uniform"), "did you mean field?"),
        (("invert", "mesh.max_node=3"), "did you mean mesh.max_nodes?"),
        (("discover", "some/folder"), "write data=some/folder"),
        (("register", "material.conductivty=3"), "did you mean material.conductivity?"),
    ],
)
def test_a_misspelt_setting_is_told_by_its_right_name(
    command: Command, words: tuple[str, ...], meant: str
) -> None:
    outcome = command(*words)
    assert outcome.code == 2 and meant in outcome.err
    assert "did you mean" not in command(words[0], "qqqq=1").err
    # What would have been accepted is listed.
    limit = next(line for line in outcome.err.splitlines() if line.strip().startswith("limit:"))
    assert ", out, " in limit and "hydra" not in limit and "defaults" not in limit

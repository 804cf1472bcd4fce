"""The command in this process, and the block's folder."""

from __future__ import annotations

import logging
import shutil
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from beartype.roar import BeartypeDecorHintPep585DeprecationWarning
from box_scene import write_block
from hydra._internal.hydra import Hydra

with warnings.catch_warnings():
    # The checker of annotations minds an old spelling inside OmegaConf.
    warnings.simplefilter("ignore", BeartypeDecorHintPep585DeprecationWarning)
    from thermo.app import main
    from thermo.report import _write_inversion, _write_prediction

SMALL = (
    "field=uniform", "optimiser=adam", "optimiser.max_steps=3", "optimiser.rate=0.2", "mesh=tet4",
    "mesh.max_nodes=1500", "integrator=backward_euler", "integrator.size=1.5",
    "initial.conductivity=2.4",
)  # fmt: skip
"""Settings of a fit that takes a moment and runs the same compiled program each time."""


@dataclass(frozen=True)
class Outcome:
    """What a command ended with and said."""

    code: int
    out: str
    err: str


Command = Callable[..., Outcome]


@pytest.fixture(scope="session")
def block(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the block; read only."""
    return write_block(tmp_path_factory.mktemp("block"))


@pytest.fixture
def own(block: Path, tmp_path: Path) -> Path:
    """A copy of the block's folder that a test may change."""
    return Path(shutil.copytree(block, tmp_path / "own"))


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The setting that keeps meshes apart from the user's."""
    return f"mesh.cache={tmp_path_factory.mktemp('meshes')}"


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Command:
    """Runs `thermo WORDS...` in an empty folder."""
    (tmp_path / "here").mkdir(exist_ok=True)
    monkeypatch.chdir(tmp_path / "here")

    # Hydra shuts all log handlers when it sets up its own, and one of them would close the stream
    # into which pytest captures.
    monkeypatch.setattr(logging, "shutdown", lambda *_: None)

    # Hydra composes a verb's settings twice, at first only for a mode that they might state. None
    # of the verbs' files does (test_help.py), and half the time of a run that is refused goes.
    monkeypatch.setattr(Hydra, "get_mode", lambda *_, **__: None)

    def run(*words: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["thermo", *map(str, words)])
        monkeypatch.setenv("HYDRA_FULL_ERROR", "0")
        capsys.readouterr()
        try:
            main()
            code = 0
        except SystemExit as end:
            code = 0 if end.code is None else int(end.code)
        said = capsys.readouterr()
        return Outcome(code, said.out, said.err)

    return run


@pytest.fixture
def unpictured(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits and predictions draw nothing: seconds each, where no test looks at pictures."""
    monkeypatch.setattr(_write_inversion, "_figures", lambda *_: None)
    for name in ("figure_curves", "figure_residuals"):
        monkeypatch.setattr(_write_prediction, name, lambda *_: None)


@pytest.fixture(scope="session")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the fit stays for all tests that look at it."""
    return tmp_path_factory.mktemp("kept") / "fit"


@pytest.fixture
def fit(command: Command, block: Path, cache: str, kept: Path) -> Path:
    """Folder of a short fit."""
    if not kept.exists():
        outcome = command("invert", f"data={block}", f"out={kept}", cache, *SMALL)
        assert outcome.code == 0, outcome.err
        (kept.parent / "said").write_text(outcome.out)
    return kept

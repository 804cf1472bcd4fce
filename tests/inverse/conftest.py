"""Scenes, meshes and fits that several tests share."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from box_scene import write_block
from bricks import lay_bricks

from thermo.inverse import Estimate, Meshing, Stepping, Uniform, invert
from thermo.observe import Scene, read_scene

START = {"conductivity": 2.4}


@pytest.fixture(scope="session")
def block(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the block without radiation; read only."""
    return write_block(tmp_path_factory.mktemp("block"))


@pytest.fixture
def own(block: Path, tmp_path: Path) -> Path:
    """A copy of the block's folder that a test may change."""
    return Path(shutil.copytree(block, tmp_path / "own"))


@pytest.fixture(scope="session")
def scene(block: Path) -> Scene:
    return read_scene(block)


@pytest.fixture(scope="session")
def meshing(tmp_path_factory: pytest.TempPathFactory) -> Meshing:
    """Linear cells, few of them, and what they make wrong is left in: it takes finer runs."""
    # All processes of a session use the same meshes, so that they share compiled programs.
    base = tmp_path_factory.getbasetemp()
    folder = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    return Meshing(order=1, max_nodes=1500, corrected=False, cache=folder / "meshes")


@pytest.fixture(scope="session")
def stepping() -> Stepping:
    """Long steps."""
    return Stepping(tolerance=0.05)


@pytest.fixture(scope="session")
def fitted(block: Path, meshing: Meshing, stepping: Stepping) -> Estimate:
    """Conductivity of the block on quadratic cells, from three times the true value."""
    quadratic = replace(meshing, order=2)
    with pytest.MonkeyPatch.context() as patch:
        lay_bricks(patch)
        return invert(block, initial=START, choice=Uniform(), meshing=quadratic, stepping=stepping)

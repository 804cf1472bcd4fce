from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from thermo import _conflict

SOURCE = Path(__file__).parents[1] / "src"


def install_other(folder: Path) -> None:
    """Writes what an installer leaves for the distribution `thermo`."""
    info = folder / "thermo-0.6.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: thermo\nVersion: 0.6.0\n")


def test_no_conflict_alone() -> None:
    assert _conflict.conflict() is None
    _conflict.refuse_conflict()


def test_our_own_distribution_is_no_conflict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = tmp_path / "thermofield-9.9.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: thermofield\nVersion: 9.9\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert _conflict.conflict() is None


def test_the_other_distribution_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install_other(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    text = _conflict.conflict()
    assert text is not None and "0.6.0" in text and str(tmp_path) in text
    with pytest.raises(ImportError, match="pip uninstall thermo thermofield"):
        _conflict.refuse_conflict()


def run(code: str, *folders: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(str(folder) for folder in folders)
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_import_prints_nothing() -> None:
    done = run("import thermo", SOURCE)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_import_beside_the_other_distribution_is_refused(tmp_path: Path) -> None:
    install_other(tmp_path)
    done = run("import thermo", SOURCE, tmp_path)
    assert done.returncode != 0
    assert "ImportError" in done.stderr and "remedy" in done.stderr

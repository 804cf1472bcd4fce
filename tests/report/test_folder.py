from __future__ import annotations

import errno
from pathlib import Path

import pytest

from thermo.errors import InputError
from thermo.report import require_writable


def test_a_missing_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    require_writable(folder)
    assert list(folder.iterdir()) == []


def test_files_in_the_folder_stay(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("{}")
    require_writable(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


@pytest.mark.parametrize("below", ["", "sub", "sub/sub"])
def test_a_file_in_the_way_is_refused(tmp_path: Path, below: str) -> None:
    (tmp_path / "out").write_text("precious")
    with pytest.raises(InputError, match="file") as caught:
        require_writable(tmp_path / "out" / below)
    assert str(tmp_path / "out") in str(caught.value) and "remedy" in str(caught.value)
    assert (tmp_path / "out").read_text() == "precious"


def test_a_name_that_no_file_system_takes_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing can be written"):
        require_writable(tmp_path / ("x" * 5000))
    with pytest.raises(InputError, match="nothing can be written"):
        require_writable(tmp_path / "a\0b")


def test_a_read_only_disk_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, data: bytes) -> int:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "write_bytes", refuse)
    with pytest.raises(InputError, match="Read-only file system"):
        require_writable(tmp_path)

"""A folder that one process works in is closed to others, and open once that has ended."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from thermo.errors import InputError
from thermo.report import claimed

HOLD = """
import os, sys
from pathlib import Path
from thermo.report import claimed
with claimed(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read(1)
    os._exit(1)
"""


def test_a_second_claim_is_refused_and_the_first_stands(tmp_path: Path) -> None:
    with claimed(tmp_path):
        for _ in range(2):
            with pytest.raises(InputError, match="another process works"), claimed(tmp_path):
                raise AssertionError("it was let in")
        assert [one.name for one in tmp_path.iterdir()] == [".in_use"]
    assert list(tmp_path.iterdir()) == []
    with claimed(tmp_path):
        pass


def test_an_error_within_gives_it_up(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), claimed(tmp_path):
        raise KeyboardInterrupt
    with claimed(tmp_path):
        pass


def test_a_process_that_is_ended_gives_it_up(tmp_path: Path) -> None:
    words = [sys.executable, "-c", HOLD, str(tmp_path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True) as other:
        assert other.stdout is not None and other.stdin is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(InputError, match=f"process {other.pid}"), claimed(tmp_path):
            raise AssertionError("it was let in")
        other.stdin.write("x")
        other.stdin.flush()
        assert other.wait(60) == 1
    # It left its file, which claims nothing.
    assert (tmp_path / ".in_use").exists()
    with claimed(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []

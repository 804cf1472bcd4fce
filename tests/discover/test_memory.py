"""Pieces that are finished are found again, and only by what made them."""

from __future__ import annotations

from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays

from thermo.discover._memory import Memory, forget, memory_of
from thermo.discover.candidates import HeaterLag, HeaterPower


class Worker:
    """Makes the same arrays each time, and counts how often."""

    def __init__(self, *made: np.ndarray) -> None:
        self.made, self.times = made, 0

    def __call__(self) -> list[np.ndarray]:
        self.times += 1
        return list(self.made)


WORK = (np.array([1.0, np.nan, -np.inf]), np.zeros((0, 3)), np.arange(6.0).reshape(2, 3).T)


def test_a_piece_is_made_once_and_is_the_same_in_every_bit(tmp_path: Path) -> None:
    work, memory = Worker(*WORK), Memory(tmp_path / "progress", "mine")
    first = memory.recalled("fit", 1.5, work)
    assert memory.spared == []
    again = Memory(tmp_path / "progress", "mine")
    found = again.recalled("fit", 1.5, work)
    assert work.times == 1 and len(again.spared) == 1 and again.spared[0] >= 0
    for one, two, three in zip(first, found, WORK, strict=True):
        assert one.tobytes() == two.tobytes() and np.array_equal(two, three, equal_nan=True)
        assert one.flags.c_contiguous and two.flags.c_contiguous and one.dtype == two.dtype


@given(arrays(np.float64, (2, 3)))
def test_without_a_folder_nothing_is_written_and_the_arrays_are_the_same(made: np.ndarray) -> None:
    work = Worker(made.T)
    for times in (1, 2):
        (found,) = Memory().recalled("fit", 1.5, work)
        assert work.times == times and found.flags.c_contiguous
        assert found.tobytes() == np.ascontiguousarray(made.T).tobytes()


@pytest.mark.parametrize("folder", [True, False])
def test_the_last_piece_of_a_kind_is_at_hand(tmp_path: Path, folder: bool) -> None:
    work, memory = Worker(*WORK), Memory(tmp_path if folder else None, "mine")
    first, again = (memory.lately("finer", 1.5, work) for _ in range(2))
    assert work.times == 1 and again is first and memory.spared == []
    # Another kind leaves it there, another piece of its own takes its place.
    memory.lately("other", 1.5, work)
    assert memory.lately("finer", 1.5, work) is first
    memory.lately("finer", 2.5, work)
    assert work.times == 3
    memory.lately("finer", 1.5, work)
    assert work.times == (3 if folder else 4)


@pytest.mark.parametrize(("asked", "kind", "of"), [
    ("theirs", "fit", 1.5), ("mine", "scores", 1.5), ("mine", "fit", 2.5),
])  # fmt: skip
def test_another_question_finds_nothing(tmp_path: Path, asked: str, kind: str, of: float) -> None:
    work = Worker(*WORK)
    Memory(tmp_path, "mine").recalled("fit", 1.5, work)
    Memory(tmp_path, asked).recalled(kind, of, work)
    assert work.times == 2
    # And the first is still there.
    Memory(tmp_path, "mine").recalled("fit", 1.5, work)
    assert work.times == 2


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-40])


def one_bit(file: Path) -> None:
    raw = bytearray(file.read_bytes())
    place = raw.find(np.float64(77.5).tobytes())
    assert place > 0
    raw[place] ^= 1
    file.write_bytes(bytes(raw))


def no_archive(file: Path) -> None:
    file.write_text("nothing")


def of_another(file: Path) -> None:
    np.savez(file, key=np.asarray("x" * 32), seconds=1.0, count=1, part_0000=np.zeros(3))


def pickled(file: Path) -> None:
    np.savez(file, key=np.asarray(file.name[4:36]), seconds=1.0, count=1,
             part_0000=np.array([{}], object))  # fmt: skip


@pytest.mark.parametrize("damage", [cut, one_bit, no_archive, of_another, pickled])
def test_a_piece_that_is_damaged_is_made_anew(tmp_path: Path, damage: object) -> None:
    work = Worker(np.full(50, 77.5))
    Memory(tmp_path).recalled("fit", 1.5, work)
    (file,) = tmp_path.iterdir()
    damage(file)  # type: ignore[operator]
    for times in (2, 2):
        (found,) = Memory(tmp_path).recalled("fit", 1.5, work)
        assert work.times == times and np.all(found == 77.5)


def test_where_nothing_can_be_written_it_goes_on_without(tmp_path: Path) -> None:
    work, place = Worker(*WORK), tmp_path / "file"
    place.write_text("mine")
    for times in (1, 2):
        Memory(place / "progress").recalled("fit", 1.5, work)
        assert work.times == times
    assert place.read_text() == "mine"


def test_what_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> list[np.ndarray]:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Memory(tmp_path).recalled("fit", 1.5, fail)
    assert list(tmp_path.iterdir()) == []


def test_forgetting_removes_pieces_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "progress"
    Memory(folder).recalled("fit", 1.5, Worker(*WORK))
    (file,) = folder.iterdir()
    # What a process that was ended in the middle of a file leaves.
    (folder / f".{file.name}.123.abcd.npz").write_text("half")
    (folder / "mine.txt").write_text("mine")
    forget(folder)
    assert [one.name for one in folder.iterdir()] == ["mine.txt"]
    (folder / "mine.txt").unlink()
    forget(folder)
    assert not folder.exists()
    forget(folder)


def test_other_candidates_are_another_question(tmp_path: Path) -> None:
    power, lag = HeaterPower(jnp.zeros(1)), HeaterLag(jnp.zeros(1), pulse=jnp.ones(()))
    asked = [memory_of(tmp_path, some).asked for some in ((power,), (lag,), (power, lag))]
    assert len(set(asked)) == 3 and memory_of(tmp_path, (power,)).asked == asked[0]
    assert memory_of(None, (power,)).folder is None

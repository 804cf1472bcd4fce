"""Checkpoints: round trip, and refusal of what is damaged."""

from __future__ import annotations

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import Checkpoint, Network, load_checkpoint, save_checkpoint
from thermo.inverse._checkpoint import leaves_of, parameters_of
from thermo.inverse._objective import start

from .objectives import beliefs

LIKE = {"conductivity": jnp.arange(3.0), "emissivity": jnp.asarray([0.5])}
HERE = leaves_of(LIKE)


def state() -> Checkpoint:
    best = [leaf + 1 for leaf in HERE]
    memory = {"step_size": np.asarray(0.25), "leaf_000": np.arange(2)}
    return Checkpoint("key", [[np.arange(2.0)]], HERE, best, 0.5, [[3.0, 2.0], [1.0]], memory)


def test_round_trip(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.npz"
    save_checkpoint(file, state())
    again = load_checkpoint(file, "key")
    assert again is not None
    assert (again.key, again.best_loss) == ("key", 0.5)
    assert again.history == [[3.0, 2.0], [1.0]]
    assert len(again.ends) == 1 and np.array_equal(again.ends[0][0], [0.0, 1.0])
    for mine, theirs in ((again.parameters, HERE), (again.best, state().best)):
        assert all(map(np.array_equal, mine, theirs))
    assert again.memory["step_size"] == 0.25
    assert np.array_equal(again.memory["leaf_000"], [0, 1])
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint.npz"]


def test_no_file_is_no_checkpoint(tmp_path: Path) -> None:
    assert load_checkpoint(tmp_path / "none.npz", "key") is None


def damaged(file: Path, kind: str) -> None:
    save_checkpoint(file, state())
    data = file.read_bytes()
    if kind == "truncated":
        file.write_bytes(data[: len(data) // 2])
    elif kind == "empty":
        file.write_bytes(b"")
    elif kind == "text":
        file.write_text("no archive")
    elif kind == "flipped":
        place = data.index(b"best_000") + 165
        file.write_bytes(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
    elif kind == "pickled":
        np.savez(file, key=np.asarray("key"), now_000=np.array([{}], dtype=object))


KINDS = ["truncated", "empty", "text", "flipped", "pickled"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_checkpoint_is_refused_with_the_remedy(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.npz"
    damaged(file, kind)
    with pytest.raises(InputError) as caught:
        load_checkpoint(file, "key")
    assert caught.value.where == str(file)
    assert "delete" in caught.value.remedy
    assert len(str(caught.value).splitlines()) == 4


def test_parameters_of_another_shape_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.npz"
    save_checkpoint(file, state())
    other = {"conductivity": jnp.zeros(4), "emissivity": jnp.zeros(1)}
    saved = load_checkpoint(file, "key")
    assert saved is not None
    with pytest.raises(InputError, match="cannot be read") as caught:
        parameters_of(saved.parameters, other, str(file))
    assert caught.value.where == str(file) and "delete" in caught.value.remedy


def test_a_failed_write_leaves_the_older_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "checkpoint.npz"
    save_checkpoint(file, state())
    before = file.read_bytes()

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="No space"):
        save_checkpoint(file, state())
    assert file.read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1


def test_the_network_of_a_field_survives(tmp_path: Path) -> None:
    like = start(beliefs(choice=Network(count=4, octaves=1, width=4, depth=1)))
    file = tmp_path / "checkpoint.npz"
    save_checkpoint(file, Checkpoint("key", [], leaves_of(like), leaves_of(like), 1.0, [[1.0]]))
    saved = load_checkpoint(file, "key")
    assert saved is not None
    again = parameters_of(saved.parameters, like, str(file))
    assert jax.tree.structure(again) == jax.tree.structure(like)
    assert all(map(np.array_equal, jax.tree.leaves(again), jax.tree.leaves(like)))

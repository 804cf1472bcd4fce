"""What an interrupted training leaves, and how it goes on."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo.errors import InputError
from thermo.observe import read_npz, write_whole

State = TypeVar("State")


def question(*parts: object) -> str:
    """A short text that differs wherever any array or number in `parts` differs."""
    digest = hashlib.sha256()
    for part in parts:
        leaves, shape = jax.tree.flatten(part)
        digest.update(str(shape).encode())
        for leaf in leaves:
            digest.update(np.asarray(leaf).tobytes() if eqx.is_array(leaf) else repr(leaf).encode())
    return digest.hexdigest()[:24]


def save_checkpoint(path: Path, asked: str, state: object, squares: np.ndarray) -> None:
    """Write the arrays of `state` and the mean square [1] of each step, whole or not at all.

    Raises `InputError` where the folder takes no file.
    """
    arrays = {f"leaf_{n:04d}": np.asarray(one) for n, one in enumerate(_arrays(state))}
    arrays |= {"question": np.asarray(asked), "squares": squares}
    with write_whole(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, allow_pickle=False, **arrays)


def load_checkpoint(path: Path, asked: str, like: State) -> tuple[State, np.ndarray] | None:
    """The state of a training that stopped and the squares [1] of its steps, or None.

    Arguments: `asked`: the question of this training. `like`: a state of the same structure.

    Raises `InputError` where the file belongs to another training or cannot be read.
    """
    if not path.exists():
        return None
    found = str(read_npz(path, required=("question",))["question"])
    if found != asked:
        raise InputError(
            "this checkpoint belongs to another training", where=str(path), value=found,
            limit=f"{asked}, the same photographs and settings as when it stopped",
            remedy="give another `out` folder, or delete the file to start anew",
        )  # fmt: skip
    mine = _arrays(like)
    labels = [f"leaf_{number:04d}" for number in range(len(mine))]
    stored = read_npz(path, required=(*labels, "squares"))
    dynamic, static = eqx.partition(like, eqx.is_array)
    leaves = [jnp.asarray(stored[label]) for label in labels]
    rebuilt = jax.tree.unflatten(jax.tree.structure(dynamic), leaves)
    return eqx.combine(rebuilt, static), stored["squares"]


def _arrays(state: object) -> list[jax.Array]:
    return jax.tree.leaves(eqx.filter(state, eqx.is_array))

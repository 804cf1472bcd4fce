"""What an interrupted fit leaves, and how it goes on."""

from __future__ import annotations

import os
import tempfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final
from zipfile import BadZipFile

import jax
import jax.numpy as jnp
import numpy as np

from thermo.errors import InputError
from thermo.inverse._objective import Parameters


@final
@dataclass(frozen=True)
class Checkpoint:
    """A fit after some steps.

    - `key`: what was being fitted; another fit never takes it up.
    - `stage`: number of the stage [1]; `parameters`, `best` [1]; `memory`: of the optimiser.
    - `history`: loss after each step of each stage [1]; `best_loss` [1].
    """

    key: str
    stage: int
    parameters: Parameters
    best: Parameters
    best_loss: float
    history: list[list[float]]
    memory: dict[str, Any] = field(default_factory=dict)


def save_checkpoint(path: Path, state: Checkpoint) -> None:
    """Write a checkpoint so that a reader finds the old one or the new one, never a part."""
    arrays: dict[str, np.ndarray] = {
        "key": np.asarray(state.key),
        "stage": np.asarray(state.stage),
        "best_loss": np.asarray(state.best_loss),
        "lengths": np.asarray([len(losses) for losses in state.history]),
        "losses": np.asarray([loss for losses in state.history for loss in losses]),
    }
    for label, tree in (("now", state.parameters), ("best", state.best)):
        for number, leaf in enumerate(jax.tree.leaves(tree)):
            arrays[f"{label}_{number:03d}"] = np.asarray(leaf)
    arrays.update({f"memory_{name}": value for name, value in state.memory.items()})
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".npz")
    os.close(handle)
    try:
        np.savez(name, allow_pickle=False, **arrays)
        os.chmod(name, 0o644)  # what mkstemp makes only its owner may read
        os.replace(name, path)
    finally:
        Path(name).unlink(missing_ok=True)


def load_checkpoint(path: Path, key: str, like: Parameters) -> Checkpoint | None:
    """Read a checkpoint of the same fit, or None where there is none.

    Arguments: `key`: what is being fitted; `like`: parameters [1] of the same structure.

    Raises `InputError` where the file belongs to another fit or cannot be read.
    """
    if not path.exists():
        return None
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            arrays = dict(stored)
        if str(arrays["key"]) != key:
            raise InputError(
                "this checkpoint belongs to another fit",
                where=str(path),
                value=str(arrays["key"]),
                limit=f"{key}, the same data and settings as the fit that was interrupted",
                remedy="give another `out` folder, or delete the file to start anew",
            )
        return _restore(arrays, like)
    except InputError:
        raise
    except (OSError, EOFError, KeyError, ValueError, BadZipFile, zlib.error) as fault:
        raise InputError(
            "this checkpoint cannot be read",
            where=str(path),
            value=f"{type(fault).__name__}: {fault}",
            limit="a file that an interrupted fit left",
            remedy="delete it to start anew",
        ) from fault


def _restore(arrays: dict[str, np.ndarray], like: Parameters) -> Checkpoint:
    leaves, shape = jax.tree.flatten(like)
    trees = []
    for label in ("now", "best"):
        stored = [arrays[f"{label}_{number:03d}"] for number in range(len(leaves))]
        for mine, leaf in zip(stored, leaves, strict=True):
            if mine.shape != np.shape(leaf):
                raise ValueError(f"parameters of shape {mine.shape}, not {np.shape(leaf)}")
        trees.append(jax.tree.unflatten(shape, [jnp.asarray(mine) for mine in stored]))
    ends = np.cumsum(arrays["lengths"])[:-1]
    memory = {
        name.removeprefix("memory_"): value
        for name, value in arrays.items()
        if name.startswith("memory_")
    }
    return Checkpoint(
        key=str(arrays["key"]),
        stage=int(arrays["stage"]),
        parameters=trees[0],
        best=trees[1],
        best_loss=float(arrays["best_loss"]),
        history=[list(map(float, part)) for part in np.split(arrays["losses"], ends)],
        memory=memory,
    )

"""What an interrupted fit leaves, and how it goes on."""

from __future__ import annotations

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
from thermo.observe import replacing

Leaves = list[np.ndarray]
"""Parameters [1] without their names, as a file holds them."""


@final
@dataclass(frozen=True)
class Checkpoint:
    """A fit after some steps.

    - `key`: what was being fitted; another fit never takes it up.
    - `ends`: parameters [1] where each finished stage ended.
    - `parameters`, `best`: of the present stage [1]; `best_loss`: there [1].
    - `history`: loss after each step of each stage [1]; `memory`: of the optimiser.
    """

    key: str
    ends: list[Leaves]
    parameters: Leaves
    best: Leaves
    best_loss: float
    history: list[list[float]]
    memory: dict[str, Any] = field(default_factory=dict)


def save_checkpoint(path: Path, state: Checkpoint) -> None:
    """Write a checkpoint so that a reader finds the old one or the new one, never a part."""
    arrays: dict[str, np.ndarray] = {
        "key": np.asarray(state.key),
        "least_loss": np.asarray(state.best_loss),
        "lengths": np.asarray([len(losses) for losses in state.history]),
        "losses": np.asarray([loss for losses in state.history for loss in losses]),
    }
    parts = {f"end{number}": leaves for number, leaves in enumerate(state.ends)}
    for label, leaves in (parts | {"now": state.parameters, "best": state.best}).items():
        for number, leaf in enumerate(leaves):
            arrays[f"{label}_{number:03d}"] = leaf
    arrays.update({f"memory_{name}": value for name, value in state.memory.items()})
    with replacing(path) as temporary:
        np.savez(temporary, allow_pickle=False, **arrays)


def _unreadable(where: str, fault: Exception) -> InputError:
    return InputError(
        "this checkpoint cannot be read",
        where=where,
        value=f"{type(fault).__name__}: {fault}",
        limit="a file that an interrupted fit left",
        remedy="delete it to start anew",
    )


def load_checkpoint(path: Path, key: str) -> Checkpoint | None:
    """Read a checkpoint of the same fit, or None where there is none.

    Arguments: `key`: what is being fitted.

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
        return _restore(arrays)
    except InputError:
        raise
    except (OSError, EOFError, KeyError, ValueError, BadZipFile, zlib.error) as fault:
        raise _unreadable(str(path), fault) from fault


def _restore(arrays: dict[str, np.ndarray]) -> Checkpoint:
    def leaves(label: str) -> Leaves:
        return [arrays[name] for name in sorted(arrays) if name.startswith(f"{label}_")]

    stages = len(arrays["lengths"])
    cuts = np.cumsum(arrays["lengths"])[:-1]
    memory = {
        name.removeprefix("memory_"): value
        for name, value in arrays.items()
        if name.startswith("memory_")
    }
    return Checkpoint(
        key=str(arrays["key"]),
        ends=[leaves(f"end{number}") for number in range(stages - 1)],
        parameters=leaves("now"),
        best=leaves("best"),
        best_loss=float(arrays["least_loss"]),
        history=[list(map(float, part)) for part in np.split(arrays["losses"], cuts)],
        memory=memory,
    )


def leaves_of(parameters: Parameters) -> Leaves:
    """The arrays of parameters [1], in the order of their names."""
    return [np.asarray(leaf) for leaf in jax.tree.leaves(parameters)]


def parameters_of(leaves: Leaves, like: Parameters, where: str) -> Parameters:
    """The arrays of a checkpoint as parameters [1] of the structure of others.

    Raises `InputError`, which names the file `where`, for arrays of other shapes.
    """
    mine, shape = jax.tree.flatten(like)
    if [np.shape(leaf) for leaf in leaves] != [np.shape(leaf) for leaf in mine]:
        found = ", ".join(str(np.shape(leaf)) for leaf in leaves) or "none"
        raise _unreadable(where, ValueError(f"parameters of shapes {found}"))
    return jax.tree.unflatten(shape, [jnp.asarray(leaf) for leaf in leaves])

"""Effects that were found, as arrays in the file of an estimate, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

import jax
import jax.numpy as jnp
import numpy as np

from thermo.discover._candidate import Candidate, with_edge
from thermo.discover._library import Setting, setting_of
from thermo.discover._registered import registered
from thermo.errors import InputError
from thermo.inverse import load_estimate, saved_effects
from thermo.observe import Scene, read_scene

_SEPARATOR: Final = "/"


def effects_as_arrays(effects: Sequence[Candidate]) -> dict[str, np.ndarray]:
    """Every array of the effects, by `NUMBER/NAME/LEAF`: strengths, places [m], times [s]."""
    found = {}
    for number, one in enumerate(effects):
        for path, leaf in jax.tree_util.tree_flatten_with_path(one)[0]:
            key = _SEPARATOR.join((str(number), one.card.name, jax.tree_util.keystr(path)))
            found[key] = np.asarray(leaf)
    return found


def load_effects(
    folder: str | Path,
    data: Scene | str | Path,
    candidates: Callable[[Setting], tuple[Candidate, ...]] = registered,
) -> tuple[Candidate, ...]:
    """The effects that `thermo discover` added to what a scene states; none for another fit.

    They are what `thermo.inverse.predict` takes as `additions`.

    Arguments:

    - `folder`: that `thermo discover` left; `data`: the scene, or its folder.
    - `candidates`: as they were for `discover`, of which those found are taken.

    Raises `InputError` where the file cannot be read, or where an effect is not a candidate.
    """
    path = Path(folder) / "estimate.npz"
    arrays = saved_effects(path)
    if not arrays:
        return ()
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    mesh, *_ = load_estimate(path)
    known = {one.card.name: one for one in candidates(setting_of(scene, scene.runs.values(), mesh))}
    kinds: dict[int, str] = {}
    for key in arrays:
        number, name, _ = key.split(_SEPARATOR, 2)
        kinds[int(number)] = name
    return tuple(
        _filled(known, name, f"{number}{_SEPARATOR}{name}{_SEPARATOR}", arrays, path)
        for number, name in sorted(kinds.items())
    )


def _filled(
    known: Mapping[str, Candidate],
    name: str,
    begin: str,
    arrays: Mapping[str, np.ndarray],
    path: Path,
) -> Candidate:
    """The candidate of a name with its arrays as saved, each in its unit."""
    if name not in known:
        raise InputError(
            "this effect is not among the candidates", where=str(path), value=name,
            limit="one of " + ", ".join(sorted(known)),
            remedy="give the candidates that were searched, or install what registers them",
        )  # fmt: skip
    told = {key for key in arrays if key.startswith(begin)}
    forms = [jax.tree_util.tree_flatten_with_path(one)
             for one in (known[name], with_edge(known[name]))]  # fmt: skip
    named = [
        ([begin + jax.tree_util.keystr(way) for way, _ in leaves], tree) for leaves, tree in forms
    ]
    keys, tree = next((pair for pair in named if set(pair[0]) == told), named[0])
    if told != set(keys):
        raise InputError(
            "this effect was saved by another version of its candidate", where=str(path),
            value=", ".join(sorted(told)), limit=", ".join(sorted(keys)),
            remedy="run `thermo discover` again",
        )  # fmt: skip
    return jax.tree.unflatten(tree, [jnp.asarray(arrays[key]) for key in keys])

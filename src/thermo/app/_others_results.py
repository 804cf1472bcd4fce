"""Results of another verb in an output folder, which must not be overwritten."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from thermo.errors import InputError

_LEAVES: Final[Mapping[str, frozenset[str]]] = {
    "discover": frozenset({"verdict.json", "estimate.npz"}),
    "invert": frozenset({"result.json", "estimate.npz"}),
    "predict": frozenset({"result.json"}),
    "reconstruct": frozenset({"result.json"}),
    "simulate": frozenset({"result.json"}),
}
"""Files of each verb that another one writes under the same name."""

_RECORDS: Final = ("result.json", "verdict.json")


def keep_others_results(verb: str, out: Path) -> None:
    """Makes sure that a verb overwrites nothing that another one left in its folder.

    Its own earlier results may be replaced. A record that cannot be read stands in nobody's way.

    Raises `InputError` where files of both would have the same name.
    """
    for name in _RECORDS:
        try:
            other = json.loads((out / name).read_text("utf-8"))["verb"]
        except (OSError, ValueError, LookupError, TypeError):
            continue
        if other == verb or not _LEAVES.get(verb, frozenset()) & _LEAVES.get(other, frozenset()):
            continue
        raise InputError(
            f"this folder holds what `thermo {other}` left, which would be overwritten",
            where="out",
            value=str(out),
            limit="a folder of its own for each verb",
            remedy=f"give another folder with out=FOLDER, or remove {out / name}",
        )

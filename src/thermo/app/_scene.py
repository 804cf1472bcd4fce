"""The scene that a command was given."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from thermo.errors import InputError
from thermo.observe import Scene, read_scene, without_spikes


def scene_of(settings: Mapping[str, Any], *, drop: bool = False) -> tuple[Scene, dict[str, int]]:
    """The scene in `data`, and how many readings of each run were dropped as spikes [1].

    They are dropped where the setting `drop_spikes` or `drop` asks for that. Raises `InputError`
    for a setting that is not true or false, and as `read_scene` does.
    """
    asked = settings["drop_spikes"]
    if not isinstance(asked, bool):
        raise InputError(
            "this is neither yes nor no", where="drop_spikes", value=asked, limit="true or false",
            remedy="give drop_spikes=true to leave out single readings far off",
        )  # fmt: skip
    scene = read_scene(Path(settings["data"]))
    if not (asked or drop):
        return scene, {}
    scene, dropped = without_spikes(scene)
    told = ", ".join(f"{count} in {name}" for name, count in dropped.items())
    print(f"readings dropped as spikes: {told}", file=sys.stderr)
    return scene, dropped

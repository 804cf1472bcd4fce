"""`thermo discover`: which effect is missing in what a scene states."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from thermo import discover as discovery
from thermo.app._configuration import (
    build_meshing,
    build_stepping,
    given,
    names,
    number,
)
from thermo.app._scene import scene_of
from thermo.mesh import box_mesh
from thermo.observe import Scene
from thermo.report import (
    claimed,
    discovery_record,
    discovery_table,
    require_writable,
    write_discovery,
)

_LEFT: Final = {
    "verdict.json": "every number",
    "verdict.html": "the same drawn, one page",
    "estimate.npz": "the model with what was named, if anything was, for thermo predict",
}


def discover(settings: Mapping[str, Any]) -> None:
    """Search for what is missing, and leave `verdict.json` and a page rendered from it."""
    begun = time.monotonic()
    out = Path(settings["out"])
    arguments = {
        "runs": names(settings["runs"], "runs"),
        "unknown": names(settings["unknown"], "unknown"),
        "stepping": build_stepping(settings["integrator"]),
        "meshing": build_meshing(settings["mesh"]),
        "initial": given(settings["initial"], "initial."),
        "model_error": number(settings, "model_error", above=0.0),
    }
    scene, _ = scene_of(settings)
    arguments["candidates"] = _candidates(settings, scene)
    require_writable(out)

    def say(words: str) -> None:
        print(f"{time.monotonic() - begun:5.0f} s  {words}", file=sys.stderr, flush=True)

    progress = out / "progress"
    with claimed(out):
        if progress.exists():
            say(f"going on from {progress}")
        found = discovery.discover(scene, **arguments, checkpoint=progress, say=say)
        record = discovery_record(found)
        record |= {
            "object": scene.object,
            "seconds": time.monotonic() - begun,
            "configuration": settings,
        }
        write_discovery(out, found, record)
        discovery.forget(progress)
    told = "\n".join(record["sentences"])
    files = "\n".join(f"{out / name}: {held}" for name, held in _LEFT.items())
    print(f"{discovery_table(record)}\n\n{told}\n\n{files}")


def _candidates(
    settings: Mapping[str, Any], scene: Scene
) -> Callable[[discovery.Setting], tuple[discovery.Candidate, ...]]:
    """What makes the candidates that are looked for, their names known before there is a mesh."""
    wanted = names(settings["candidates"], "candidates")
    if wanted is None:
        return discovery.registered
    chosen = discovery.only(wanted)
    # Names do not hang on the body: a box of a metre will do.
    some = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    chosen(discovery.Setting(some, scene.material.density, 1.0, 290.0, 310.0))
    return chosen

"""What a person should look at after frames were registered, in words."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from thermo.imaging import Frames, Looks, better_order, contours_apart

_OUT_OF_PLACE: Final = 2.0
"""Contours further apart than this [px] are told of: masks of pixels may be off by one."""


def order_words(looks: Looks, frames: Sequence[Frames], files: Sequence[Path]) -> list[str]:
    """Where the recordings fit the cameras clearly better in another order."""
    order = better_order(looks, frames)
    if order is None:
        return []
    better = ", ".join(
        f"{looks.cameras[camera].name} {files[recording]}"
        for camera, recording in enumerate(order) if recording != camera
    )  # fmt: skip
    return [
        "WRONG ORDER? The silhouettes in the frames fit the cameras clearly better as follows: "
        f"{better}; frames=[a,b] stand in the order of the cameras"
    ]


def place_words(looks: Looks, frames: Sequence[Frames]) -> list[str]:
    """Where the surface does not lie where most of the cameras see the object."""
    apart = contours_apart(looks, frames)
    if apart is None or np.median(apart) <= _OUT_OF_PLACE:
        return []
    off = ", ".join(
        f"{camera.name} {one:.1f} px" for camera, one in zip(looks.cameras, apart, strict=True)
    )
    return [
        "OUT OF PLACE? What is apart from the room in the frames has its contour off the "
        f"surface's: {off}. Where it is the whole object, align=pose brings the surface there"
    ]


def stood_before(out: Path) -> str | None:
    """The surface's file of a scene that stands in a folder; None where none does."""
    try:
        return str(json.loads((out / "scene.json").read_text("utf-8"))["surface"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def replaced_words(out: Path, before: str | None) -> list[str]:
    """That the scene that stood in `out` is no more, and which file of it lies about unused."""
    if before is None:
        return []
    words = f"the scene that stood in {out} was replaced"
    if before != stood_before(out) and (out / before).is_file():
        words += f"; its surface {before} still lies there and is not used"
    return [words]

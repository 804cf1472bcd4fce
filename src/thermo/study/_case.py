"""One fit of a study: what is fitted, how, and to what."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, final

from thermo.errors import InputError
from thermo.observe import Scene, read_scene, with_camera_noise
from thermo.study._paper import Row
from thermo.study._preset import Preset

Part = Literal["tables", "processes", "smoothness", "ensembles"]


@final
@dataclass(frozen=True)
class Case:
    """A row under one preset.

    - `data`: folder that holds the scenes; `noisy`: whether a camera's noise is put on.
    - `held_out`: whether held-out runs are predicted.
    - `part`: of the study that it belongs to; only `tables` and `processes` ask before the fit
      what is to be expected.
    - `seed`: of noise and fields; `start`: factor on the first values beside the row's own [1].
    - `step`: smoothness in place of the preset's, None for that [1].
    """

    row: Row
    preset_name: str
    preset: Preset
    data: Path
    noisy: bool
    held_out: bool
    part: Part = "tables"
    seed: int = 0
    start: float = 1.0
    step: float | None = None

    def name(self) -> str:
        """File name of the case without its ending."""
        words = [self.row.name(), self.preset_name, "camera" if self.noisy else "none"]
        if self.part == "ensembles":
            words.append(f"start-{self.start:g}-seed-{self.seed}")
        if self.step is not None:
            words.append(f"step-{self.step:g}")
        return "-".join(words)

    def key(self) -> str:
        """A hash that another case does not share; the meshes' folder is no part of it."""
        meshing = replace(self.preset.meshing, cache=None)
        asked = replace(self, data=Path(), preset=replace(self.preset, meshing=meshing))
        scene = (self.data / self.row.object / "scene.json").read_bytes()
        return hashlib.sha256(repr(asked).encode() + scene).hexdigest()[:16]

    def scene(self) -> Scene:
        """The scene as it was recorded: a camera's noise on what is fitted, where asked for."""
        scene = read_scene(self.data / self.row.object)
        if not self.noisy:
            return scene
        runs = {
            name: run if run.held_out else replace(
                run,
                recording=with_camera_noise(
                    run.recording, run.initial_temperature, seed=self.seed
                ),
            )
            for name, run in scene.runs.items()
        }  # fmt: skip
        return replace(scene, runs=runs)


def truth(scene: Scene, quantity: str) -> float:
    """The true value [SI] of a scene of the paper. Fits never see it.

    Raises `InputError` where the scene does not tell.
    """
    capacity = scene.material.volumetric_heat_capacity()
    if quantity == "scaled_convection" and scene.convection is not None:
        return scene.convection / capacity
    told = json.loads((scene.folder / "scene.json").read_text("utf-8")).get("truth", {})
    if quantity not in told:
        raise InputError(
            "the scene does not tell the truth that a study compares with",
            where=f"{scene.folder}/scene.json: truth.{quantity}",
            value="missing",
            limit="a number [SI]",
            remedy="study scenes of which the answer is known",
        )
    return float(told[quantity])

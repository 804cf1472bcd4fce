"""From photographs to a closed surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from thermo.mesh import Surface

from ._extract_surface import extract_surface, require_extra
from ._photograph import Photograph
from ._region import Region
from ._train import Trained, distance_of, train
from ._training import Training


class Reconstruction(NamedTuple):
    """A closed surface [m], and what it was taken from."""

    surface: Surface
    trained: Trained


def reconstruct(
    photographs: Sequence[Photograph],
    region: Region,
    training: Training | None = None,
    *,
    triangles: int = 20000,
    checkpoint: Path | None = None,
    on_step: Callable[[int, int, float], None] = lambda *_: None,
) -> Reconstruction:
    """Train a signed distance on photographs and take its zero set.

    Arguments: as `train` takes them; `training` None stands for that of two cores; `triangles` of
    the surface at the most [1]. It is taken on cells half as large as those of the finest grid.

    Raises `InputError` as `train` and `extract_surface` do.

    Source: paper, section 4.1 and appendix B.1 (checklist A1 to A6).
    """
    require_extra()
    training = Training() if training is None else training
    trained = train(photographs, region, training, checkpoint=checkpoint, on_step=on_step)
    surface = extract_surface(
        distance_of(trained), region, cells=2 * max(training.cells), triangles=triangles
    )
    return Reconstruction(surface, trained)

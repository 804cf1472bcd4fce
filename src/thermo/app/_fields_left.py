"""What a fit of fields leaves open of them, as far as the time of `thermo identify` goes."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field
from typing import final

from thermo import inverse
from thermo.app._configuration import build_meshing, build_prior, build_stepping, number
from thermo.app._fitted import Fitted
from thermo.app._regions import Regions, region_means
from thermo.identify import RegionMean
from thermo.inverse import Band, FieldPosterior
from thermo.observe import Scene


@final
@dataclass(frozen=True)
class WantedOfFields:
    """`budget` [s]; `controls`: points where fields may depart; `bands`: draws [1]; `seed`.

    `regions`: those over which means are wanted.
    """

    budget: float
    controls: int
    bands: int
    seed: int
    regions: Regions


@final
@dataclass
class FieldsLeft:
    """What is left open of fields and predictions, by run, and in words what was not made.

    `means`: of each field over each region.
    """

    posterior: FieldPosterior | None = None
    bands: dict[str, Band] = field(default_factory=dict)
    means: list[RegionMean] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)


def fields_left(scene: Scene, fitted: Fitted, wanted: WantedOfFields) -> FieldsLeft:
    """Bands of fields and of the runs that are held out, with what the fit was asked [SI].

    The bands of a run are not begun once `wanted.budget` is spent, and after them as much time is
    for profiles of means.
    """
    if wanted.controls == 0:
        return FieldsLeft(
            left_out=["Bands of fields and predictions, means over regions: controls is 0."]
        )
    asked = fitted.settings
    model_error = number(asked, "model_error", above=0.0)
    print(f"what the data leave open on up to {wanted.controls} control points", file=sys.stderr)
    posterior = inverse.posterior(
        scene,
        fitted.folder,
        count=wanted.controls,
        runs=fitted.runs,
        prior=build_prior(asked["prior"]),
        stepping=build_stepping(asked["integrator"]),
        meshing=build_meshing(asked["mesh"]),
        seed=number(asked, "seed", whole=True),
        model_error=model_error,
    )
    found, begun = FieldsLeft(posterior), time.monotonic()
    for name, run in scene.runs.items():
        if not run.held_out:
            continue
        if wanted.bands == 0 or time.monotonic() - begun > wanted.budget:
            why = "bands is 0" if wanted.bands == 0 else f"{wanted.budget:g} s were spent"
            found.left_out.append(f"Bands of {name}: {why}.")
            continue
        found.bands |= inverse.bands(
            scene, posterior, runs=(name,), draws=wanted.bands, seed=wanted.seed,
            model_error=model_error,
        )  # fmt: skip
        print(f"bands of {name}", file=sys.stderr)
    found.means, missed = region_means(posterior, wanted.regions, wanted.budget)
    found.left_out += missed
    return found

"""What was found so far, put together and written."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, final

import numpy as np

from thermo import inverse
from thermo.app._fields_left import FieldsLeft
from thermo.app._fitted import Fitted
from thermo.app._refits import Refits
from thermo.app._regions import mean_sentences
from thermo.identify import (
    Identifiability,
    NextRun,
    Shift,
    field_findings,
    field_sentences,
    identifiability,
    next_runs,
    shifts,
    unknowns_of,
)
from thermo.inverse import DEFECT_SPREAD, UNEXPLAINED, FieldPosterior
from thermo.observe import ResidualNoise, Scene
from thermo.report import (
    band_record,
    field_record,
    identifiability_record,
    mean_record,
    surface_record,
    write_identifiability,
)


@final
@dataclass(frozen=True)
class Analysis:
    """What was asked, the slopes [K] of unknowns and doubted values, and when it began [s]."""

    settings: Mapping[str, Any]
    scene: Scene
    whole: inverse.Sensitivity
    doubt: Mapping[str, float]
    candidates: Mapping[str, inverse.Sensitivity]
    split: tuple[str, str] | None
    prior: Mapping[str, float]
    model_error: float
    wanted: float
    fitted: Fitted | None
    begun: float

    def leave(self, out: Path, more: Refits, left: FieldsLeft) -> dict[str, Any]:
        """Write what is known so far; returns the record."""
        at, asked = unknowns_of(self.whole, self.doubt), {"prior": self.prior}
        corrected = self.fitted is not None and self.fitted.corrected
        at = allowing(at, more.defect, corrected=corrected)
        whole, at = (learnt(one, more.noise) for one in (self.whole, at))
        moved = shifts(whole, self.doubt, model_error=self.model_error, **asked)
        found = identifiability(at, model_error=self.model_error, wanted=self.wanted, **asked)
        chosen = next_runs(
            at, self.candidates, split=self.split, model_error=self.model_error, **asked
        )
        found = found if left.posterior is None else _of_fields(found, left.posterior)
        means = () if left.posterior is None else tuple(left.posterior.fields)
        left_out = [*left.left_out, *more.left_out]
        runs = [self.scene.runs[name] for name in at.slopes]
        record = identifiability_record(
            found, at, runs, more.profiles, more.basins, left_out, more.noise
        )
        record["sentences"] = [
            # What no interval allows for is read before the intervals.
            *([] if self.fitted is None else self.fitted.unexplained),
            *_misfit(more),
            *found.sentences(before=self.fitted is None, means=means),
            *([] if left.posterior is None else field_sentences(left.posterior)),
            *mean_sentences(left.means),
            *_banded(left),
            *_doubts(found, more),
            *_from_residuals(more),
            *whole_frames(at),
            *_moved(moved),
            *_next(chosen),
            *([] if self.fitted else first_guesses(self.scene, self.settings["initial"], at.names)),
        ]
        record |= {"next_runs": [asdict(one) for one in chosen]}
        record |= {"means": [mean_record(one) for one in left.means]}
        record |= {"fields": field_record(left.posterior), "bands": band_record(left.bands)}
        record |= {"surface": surface_record(left.posterior)}
        record |= {"shifts": [asdict(one) for one in moved], "misfit": more.misfit}
        record |= {"seconds": time.monotonic() - self.begun, "model_error": self.model_error}
        record |= {"before_fit": self.fitted is None, "configuration": self.settings}
        record |= {"defect_K": {name: _size(apart) for name, apart in more.defect.items()}}
        title = f"{self.scene.object}: what {', '.join(at.slopes)} tell"
        write_identifiability(out, record, title)
        return record


def allowing(
    at: inverse.Sensitivity, defect: Mapping[str, np.ndarray], *, corrected: bool
) -> inverse.Sensitivity:
    """Slopes beside what the fit's cells and steps still make wrong, by run [K].

    A `corrected` fit has taken off all but `DEFECT_SPREAD` of it, any other nothing.
    """
    left = DEFECT_SPREAD if corrected else 1.0
    cut = {
        name: left * apart[tuple(slice(length) for length in at.slopes[name].shape[:2])]
        for name, apart in defect.items()
    }
    return replace(at, defect=cut)


def learnt(at: inverse.Sensitivity, noise: Mapping[str, ResidualNoise]) -> inverse.Sensitivity:
    """Slopes beside the noise that the residual of a fit shows, in runs that have it [K]."""
    levels = {name: one.noise.long_run() for name, one in noise.items() if name in at.noise}
    stays = {name: max(noise[name].noise.offset, at.staying.get(name, 0.0)) for name in levels}
    return replace(at, noise={**at.noise, **levels}, staying={**at.staying, **stays})


def _size(apart: np.ndarray) -> float:
    """Root mean square of what there is of a defect [K]; it is zero where a run was filled up."""
    there = apart[apart != 0]
    return float(np.sqrt(np.mean(there**2))) if there.size else 0.0


def _of_fields(found: Identifiability, left: FieldPosterior) -> Identifiability:
    """The verdicts on the means of fields in place of those on one value each."""
    means = {item.name: item for item in field_findings(left, wanted=found.wanted)}
    return replace(found, findings=[means.get(item.name, item) for item in found.findings])


def first_guesses(
    scene: Scene, initial: Mapping[str, float | None], names: tuple[str, ...]
) -> list[str]:
    """Which values are neither stated nor found, in words."""
    guessed: set[str] = set()
    for value, alike in (
        (scene.material.first_conductivity(), ("conductivity", "diffusivity")),
        (scene.convection, ("convection", "scaled_convection")),
        (scene.emissivity, ("emissivity", "scaled_emissivity")),
    ):
        # One of them tells the other, by the heat capacity.
        if value is None and all(initial.get(name) is None for name in alike):
            guessed |= set(alike)
    return [
        f"Nothing is stated of {name}: its value here is a first guess, initial.{name}=VALUE gives "
        "another."
        for name in dict.fromkeys(names)
        if name in guessed
    ]


def _misfit(more: Refits) -> list[str]:
    """What is left of the fit beyond noise, in words."""
    if more.misfit is None or more.misfit <= UNEXPLAINED:
        return []
    return [
        f"Simulation and readings differ by {more.misfit:.2g} times what the noise allows: "
        "something is missing in the model, and no interval allows for that."
    ]


def _doubts(found: Identifiability, more: Refits) -> list[str]:
    """What speaks against single intervals, in words."""
    told = []
    for item in found.findings:
        made = more.profiles.get(item.name)
        if made is None:
            continue
        best = float(np.exp(made.optimum()))
        if not item.interval95[0] <= best <= item.interval95[1]:
            told.append(
                f"{item.name} comes out as {best:.4g} {item.unit} where it is fitted anew for its "
                "profile, outside that interval: the fit had not ended there, or errors of its "
                "cells and steps, which a profile allows for, are larger than the noise."
            )
    return told


def _from_residuals(more: Refits) -> list[str]:
    """Of which runs the noise is that of a residual, in words."""
    return [
        f"{name} has no quiet frames: its noise is what fluctuates in the residual of the fit, "
        f"{one.noise.white:.2g} K, of which {one.noise.correlation:.0%} is left a frame later. "
        f"{one.words()}"
        for name, one in more.noise.items()
    ]


def whole_frames(at: inverse.Sensitivity) -> list[str]:
    """What samples have in common, in words."""
    found = [f"{size:.2g} K in {run}" for run, (size, _) in at.common.items() if size > 0]
    if not found:
        return []
    return [f"Whole frames are off together, by {', '.join(found)}; the intervals allow for it."]


def _moved(found: list[Shift]) -> list[str]:
    return [
        f"Stated {100 * np.expm1(one.doubt):.2g} % too large, {one.held} moves {one.name} by "
        f"{100 * np.expm1(one.relative):+.2g} %, {abs(one.deviations):.2g} of its standard "
        "deviations."
        for one in found
    ]


def _banded(left: FieldsLeft) -> list[str]:
    return [
        f"Predictions of {name} are known to {size['median']:.2g} K in the middle and to "
        f"{size['p95']:.2g} K in 95 % of all places and times (standard deviations); "
        f"{one['inside']:.0%} of its readings lie within the 95 % band."
        for name, one in band_record(left.bands).items()
        for size in [one["deviation_K"]]
    ]


def _next(chosen: list[NextRun]) -> list[str]:
    if not chosen:
        return []
    first, size = chosen[0], chosen[0].pair or chosen[0].weakest
    of = "the combination that is known least" if first.pair is None else "the two to be split"
    return [
        f"Of the runs that could be made {first.name} tells most of {of}: of its logarithm the "
        f"standard deviation goes from {first.before:.2g} to {size:.2g}, in the worst way that "
        "they can change together. This is local to these values."
    ]

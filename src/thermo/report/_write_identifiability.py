"""Everything that a look at what the data identify leaves in its folder."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from thermo.fields import QUANTITIES
from thermo.identify import Basins, Identifiability, Profile, RegionMean
from thermo.inverse import NORMAL, Sensitivity
from thermo.observe import ResidualNoise, Run, check_quiet, estimate_noise

from ._identifiability_page import identifiability_page
from ._json import write_json
from ._table import table
from ._text import write_text
from ._versions import versions

MOST_POINTS = 2000
"""Samples of a run [1] whose responses are kept for the maps: more are thinned evenly."""


def identifiability_record(
    found: Identifiability,
    at: Sensitivity,
    runs: Sequence[Run],
    profiles: Mapping[str, Profile],
    basins: Basins | None,
    left_out: Sequence[str],
    learnt: Mapping[str, ResidualNoise] = MappingProxyType({}),
) -> dict[str, Any]:
    """Every number of an analysis as plain data: values [SI], temperatures [K], logarithms [1].

    `learnt`: by run, the noise that the residual of the fit shows [K].
    """
    return {
        "format": "thermofield-identifiability/1",
        "verb": "identify",
        "parameters": {
            item.name: {
                "value": item.value,
                "unit": item.unit,
                "sd": item.sd,
                "relative": item.relative,
                "interval95": list(item.interval95),
                "verdict": item.verdict,
                "informed_by_data": item.informed,
                "profile": _profile(profiles.get(item.name)),
            }
            for item in found.findings
        },
        "null_directions": [
            {"combination": one.words(), "weights": one.weights} for one in found.free
        ],
        "sentences": found.sentences(),
        "alike": [asdict(one) for one in found.alike],
        "spectrum": {
            "names": found.spectrum.names,
            "prior": found.spectrum.prior,
            "eigenvalues": found.spectrum.eigenvalues,
            "hidden": found.spectrum.hidden,
            "data_led": found.spectrum.data_led(),
            "directions": found.spectrum.directions,
            "correlation": found.spectrum.correlation(),
        },
        "noise": {run.name: _noise(run, at, learnt.get(run.name)) for run in runs},
        "maps": {run.name: _map(run, at) for run in runs},
        "basins": _basins(basins, found),
        "scatter": _scatter(basins, found),
        "left_out": list(left_out),
        "wanted": found.wanted,
        "versions": versions(),
    }


def _profile(found: Profile | None) -> dict[str, Any] | None:
    """A profile in values [SI]; an end that was not reached is None."""
    if found is None:
        return None
    ends = [None if end is None else float(np.exp(end)) for end in (found.lower, found.upper)]
    best = found.optimum()
    return {
        "kind": found.kind,
        "lower": ends[0],
        "upper": ends[1],
        "best": float(np.exp(best)),
        "linear": np.exp([best - found.linear, best + found.linear]),
        "nonlinear": found.nonlinear(),
        "values": np.exp(found.values),
        "rises": found.rises,
        "remainders": found.remainders,
    }


def mean_record(mean: RegionMean) -> dict[str, Any]:
    """The mean of a field over a region [SI], its interval by slopes and its profile."""
    low, high = mean.value * np.exp(NORMAL * mean.deviation * np.array([-1.0, 1.0]))
    return {
        "quantity": mean.quantity,
        "unit": QUANTITIES[mean.quantity].unit,
        "region": mean.region,
        "share": mean.share,
        "value": mean.value,
        "relative": mean.deviation,
        "interval95": [float(low), float(high)],
        "profile": _profile(mean.profile),
    }


def _basins(made: Basins | None, found: Identifiability) -> list[dict[str, Any]]:
    """Where fits from other starts end [SI], the best first; empty where none were made."""
    if made is None:
        return []
    names = found.spectrum.names
    return [
        {
            "values": dict(zip(names, np.exp(centre), strict=True)),
            "chi2": chi2,
            "share": share,
        }
        for centre, chi2, share in zip(made.centres, made.chi2, made.shares(), strict=True)
    ]


def _scatter(made: Basins | None, found: Identifiability) -> dict[str, Any] | None:
    """Variances of log(phi) over starts and over draws of the noise [1]; None without draws."""
    if made is None or made.draws == 0:
        return None
    return {
        "draws": made.draws,
        "names": found.spectrum.names,
        "optimiser": made.optimiser,
        "noise": made.noise,
        "linear": made.linear,
        "optimiser_share": made.optimiser_share(),
        "noise_as_foretold": made.noise_as_foretold(),
    }


_SOURCES = {
    "quiet": "quiet frames",
    "differences": "second differences of the record",
    "residuals": "residual of the fit",
}


def _noise(run: Run, at: Sensitivity, learnt: ResidualNoise | None) -> dict[str, Any]:
    record = run.recording
    noise = estimate_noise(record) if learnt is None else learnt.noise
    check = check_quiet(record, noise)
    frames = 0 if record.quiet is None else len(record.quiet)
    quiet = "quiet" if record.knows_quiet() else "differences"
    source = quiet if learnt is None else "residuals"
    return {
        "white": noise.white,
        "correlation": noise.correlation,
        "offset": noise.offset,
        "frame": noise.frame,
        "staying": at.staying[run.name],
        "unit": "K",
        "from": source,
        "source": _SOURCES[source],
        "quiet_frames": frames,
        "frames": len(record.time),
        "samples": len(record.points),
        "check": None if check is None else {**asdict(check), "words": check.words()},
        "residual": None
        if learnt is None
        else {
            "z": learnt.z,
            "changing": learnt.changing,
            "apart_m": learnt.apart,
            "words": learnt.words(),
        },
    }


def _map(run: Run, at: Sensitivity) -> dict[str, Any]:
    """Where the readings move with each unknown: root mean square slope over time [K]."""
    points, slopes = run.recording.points, at.slopes[run.name]
    kept = np.linspace(0, len(points) - 1, min(len(points), MOST_POINTS)).round().astype(int)
    names = dict.fromkeys(at.names)
    response = {
        name: np.sqrt(np.mean(slopes[:, kept][..., _mine(at, name)].sum(-1) ** 2, axis=0))
        for name in names
    }
    return {
        "points": np.round(points[kept], 6),
        "response": {name: _rounded(values) for name, values in response.items()},
    }


def _mine(at: Sensitivity, name: str) -> np.ndarray:
    return np.array([other == name for other in at.names])


def _rounded(values: np.ndarray) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def write_identifiability(folder: Path, record: Mapping[str, Any], title: str) -> None:
    """Write `identifiability.json`, and `identifiability.html` rendered from it, as whole files.

    `title` is what the page is headed by.
    """
    path = folder / "identifiability.json"
    write_json(path, record)
    page = identifiability_page(json.loads(path.read_text("utf-8")), title)
    write_text(folder / "identifiability.html", page)


def identifiability_table(record: Mapping[str, Any]) -> str:
    """A short table of the verdicts for a terminal."""
    rows = [
        [name, item["unit"], f"{item['value']:.6g}", f"{item['interval95'][0]:.6g}",
         f"{item['interval95'][1]:.6g}", f"{item['informed_by_data']:.3f}", item["verdict"]]
        for name, item in record["parameters"].items()
    ]  # fmt: skip
    header = ["unknown", "unit", "value", "2.5 %", "97.5 %", "informed by data", "verdict"]
    return table(rows, header)

"""Verdicts made by hand."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np

from thermo.discover import (
    Alternative,
    Calibration,
    Candidacy,
    Differences,
    Effect,
    Follows,
    HeldOut,
    Misfit,
    Part,
    Place,
    Power,
    Round,
    Trace,
    Verdict,
)
from thermo.discover.candidates import HiddenSource, SensorLag
from thermo.inverse import Estimate, RecoveredField, RunFit
from thermo.inverse._properties import Stated
from thermo.mesh import box_mesh

MESH = box_mesh((0.02, 0.02, 0.008), (2, 2, 1))
SOURCE, LAG = HiddenSource.card, SensorLag.card


def candidacies() -> list[Candidacy]:
    """A source that is seen and refitted, and a lag that is not."""
    return [
        Candidacy(SOURCE, 40.0, 1.3, 0.03, 0.8, 0.0, 0.9, -700.0),
        Candidacy(LAG, 0.4, 0.01, 0.02, 0.9, None, 0.1, None),
    ]


def one_round(together: list[str], closed: float) -> Round:
    """A source at a place."""
    centre = np.array([0.01, 0.0, 0.004])
    effect = Effect(SOURCE, 1.25, 0.02, (1.2108, 1.2892), centre, 0.005, chance=0.0)
    before, after = {"lamp": 0.5, "cooling": 0.2}, {"lamp": 0.05, "cooling": 0.06}
    others = {name: fitted_in(name) for name in together[1:]}
    return Round(candidacies(), 3.1, effect, together, 1e-30, before, after, closed, others)


def fitted_in(name: str = "sensor_lag") -> Alternative:
    """A lag in place of a source, under any name."""
    effect = Effect(replace(LAG, name=name), 0.8, 0.1, (0.604, 0.996), None, None, chance=0.0)
    values = {"conductivity": (2.3, (2.2, 2.4))}
    return Alternative(effect, values, {"lamp": 0.051, "cooling": 0.06}, {"other": 0.056})


def misfit(share: float) -> Misfit:
    """One whose smooth parts are so many times as large as noise alone leaves them."""
    return Misfit(Part(16 * share, 16), Part(176 * share, 176), Part(800.0, 808))


def trace(score: float) -> Trace:
    """One that follows a lamp."""
    return Trace(0.25, {"lamp": Follows(score, 1.5, 0.5 if abs(score) < 3 else 0.0)})


def estimate(apart: float) -> Estimate:
    """A fit that is off by so much [K] wherever x is positive, from the second frame on."""
    time, points = np.linspace(0.0, 30.0, 4), MESH.nodes[np.unique(MESH.faces)]
    measured = np.full((len(time), len(points)), 300.0)
    simulated = measured + apart * (points[:, 0] > 0.01) * (time > 0)[:, None]
    run = RunFit(apart, 0.05, 0.004, 0.05, time, points, measured, simulated)
    values = np.full(len(MESH.cells), 2.0), np.full(len(MESH.faces), 2.0)
    field = RecoveredField("conductivity", "W/m/K", *values)
    stated = Stated(2.0, 2.4e6, 8.0, 0.85)
    runs = {"lamp": run, "cooling": run}
    return Estimate(MESH, 2, stated, {"conductivity": field}, runs, [], True, 1.0, "fine", {})


def held(
    before: float,
    after: float,
    closed: float | None = None,
    ends: tuple[float, float] | None = None,
    doubt: float = 0.0,
) -> HeldOut:
    """A run that was not fitted, at a noise of 0.05 K, so far off in each of 3 x 2 readings [K]."""
    time, points = np.linspace(0.0, 10.0, 3), np.eye(3)[:2]
    apart = np.full((2, 3, 2), [[[before]], [[after]]])
    return HeldOut(before, after, 0.05, closed, ends, doubt, Differences(time, points, *apart))


def verdict(word: str) -> Verdict:
    """One of each of the four words."""
    rounds = {
        "named": [one_round(["hidden_source"], 0.99)],
        "inseparable": [one_round(["hidden_source", "sensor_lag"], 0.99)],
        "none_of_mine": [one_round(["hidden_source"], 0.4)],
        "no_gap": [],
    }[word]
    place = Place(jnp.asarray([[0.01, 0.0, 0.004]]), jnp.asarray([0.005]))
    source = HiddenSource(jnp.asarray([1.25]), place)
    return Verdict(
        verdict=word,  # type: ignore[arg-type]
        rounds=rounds,
        candidates=candidacies(),
        threshold=3.1,
        held_out={"other": held(0.4, 0.055, 0.97, (0.95, 0.98))},
        missed={
            "sensor_lag": Power("s", {0.5: 0.04, 0.8: 0.06, 0.95: 0.08}),
            "void": Power("1", {0.5: 0.9, 0.8: None, 0.95: None}),
        },
        cells={"lamp": 0.004, "cooling": 0.001},
        noise={"lamp": 0.05, "cooling": 0.05},
        parameters={"conductivity": (2.2, 2.0)},
        intervals={} if word == "none_of_mine" else {"conductivity": (1.9, 2.1)},
        alias={"hidden_source": {"hidden_source": 1.0}},
        omnibus=(1e-9, 0.4),
        misfits=(
            {"lamp": misfit(9.0), "cooling": misfit(2.0)},
            {"lamp": misfit(1.1), "cooling": misfit(1.0)},
        ),
        traces=(
            {"lamp": trace(-8.0), "cooling": Trace(0.7, {})},
            {"lamp": trace(1.2), "cooling": Trace(0.6, {})},
        ),
        calibration=Calibration(np.linspace(1.0, 3.6, 200), 0.035, 0.01, 0.045),
        stated=estimate(0.5),
        extended=estimate(0.05),
        additions=(source,) if word in ("named", "inseparable") else (),
        remarks=["A remark."],
    )

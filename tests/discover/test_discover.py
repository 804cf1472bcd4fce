"""From recordings of another program to a verdict: a hidden effect, none, one that nobody knows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from box_scene import CONVECTION, EMISSIVITY, write_block

from thermo.discover import Candidate, Place, Verdict, discover
from thermo.discover.candidates import (
    HeaterPower,
    HiddenSource,
    MissingRadiation,
    SensorLag,
    TemperatureDependentConductivity,
)
from thermo.errors import InputError
from thermo.inverse import Meshing, Stepping
from thermo.mesh import Mesh
from thermo.observe import Scene, read_scene

MESHING = Meshing(max_nodes=3000)
STEPPING = Stepping(tolerance=0.02)


def few(mesh: Mesh, duration: float) -> tuple[Candidate, ...]:
    """A small library: one program of five compiles sooner than that of all."""
    del duration
    middle = Place(jnp.asarray(mesh.nodes.mean(0))[None], jnp.asarray([0.004]))
    zero = jnp.zeros(1)
    return (
        MissingRadiation(zero),
        HiddenSource(zero, middle),
        HeaterPower(zero),
        SensorLag(zero),
        TemperatureDependentConductivity(zero),
    )


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """The block, which radiates."""
    folder: Path = write_block(tmp_path_factory.mktemp("radiating"), radiates=True)
    return replace(read_scene(folder), unknown=("conductivity", "convection"))


def asked(scene: Scene) -> Verdict:
    return discover(scene, candidates=few, meshing=MESHING, stepping=STEPPING, model_error=0.005)


def test_where_nothing_is_missing_nothing_is_named(scene: Scene) -> None:
    found = asked(scene)
    assert found.verdict == "no_gap" and found.effects() == [] and found.rounds == []
    assert found.omnibus[0] > 0.01 and found.omnibus == (found.omnibus[1], found.omnibus[1])
    assert max(abs(one.score) for one in found.candidates) < found.threshold
    assert 2 < found.threshold < 3.5
    proof = found.held_out["test_lamp"]
    assert proof.rms_before == pytest.approx(proof.rms_after) and proof.gap_closed is None
    # What could not have been missed is far below what another case hides.
    least, unit = found.missed["heater_power"]
    assert least is not None and least < 0.05 and unit == "1"


def test_radiation_that_is_not_stated_is_named_and_proved(scene: Scene) -> None:
    found = asked(replace(scene, emissivity=0.0))
    assert found.verdict == "named" and found.effects() == ["radiation"]
    (one,) = found.rounds
    assert one.together == ["radiation"] and one.p_value < 1e-6 and one.closed > 0.9
    low, high = one.effect.interval95
    assert low < EMISSIVITY < high and one.effect.strength == pytest.approx(EMISSIVITY, abs=0.15)
    assert one.effect.centre is None
    before, after = found.parameters["convection"]
    # Convection stood in for it.
    assert abs(after - CONVECTION) < abs(before - CONVECTION)
    assert one.rms_after["cooling"] < one.rms_before["cooling"]


def test_a_lamp_of_another_power_is_named_by_how_much_it_is_off(scene: Scene) -> None:
    runs = {
        name: run if run.heater is None else replace(run, heater=replace(run.heater, power=0.8 * run.heater.power))
        for name, run in scene.runs.items()
    }  # fmt: skip
    found = asked(replace(scene, runs=runs))
    assert found.effects() == ["heater_power"]
    (one,) = found.rounds
    assert one.effect.strength == pytest.approx(0.25, rel=0.03)
    proof = found.held_out["test_lamp"]
    assert proof.gap_closed is not None and proof.gap_closed > 0.95
    assert proof.rms_after < 0.2 * proof.rms_before


def test_what_no_candidate_explains_is_not_named(scene: Scene) -> None:
    """Half of the samples drift away by themselves, as a camera's corner may."""
    runs = {}
    for name, run in scene.runs.items():
        record = run.recording
        drift = np.outer(np.sin(record.time / 4.0), np.arange(len(record.points)) % 2)
        runs[name] = replace(
            run, recording=replace(record, temperature=record.temperature + 0.3 * drift)
        )
    found = asked(replace(scene, runs=runs))
    assert found.verdict == "none_of_mine" and found.effects() == []
    assert found.omnibus[0] < 1e-6


def test_two_candidates_of_one_name_are_refused(scene: Scene) -> None:
    def twice(mesh: Mesh, duration: float) -> tuple[Candidate, ...]:
        return (*few(mesh, duration), HeaterPower(jnp.zeros(1)))

    with pytest.raises(InputError, match="heater_power"):
        discover(scene, candidates=twice, meshing=MESHING, stepping=STEPPING)

"""From recordings of another program to a verdict: a lamp that is off, and nothing at all."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, final

import jax.numpy as jnp
import numpy as np
import pytest
from box_scene import write_block
from bricks import lay_bricks
from jaxtyping import Array, Float

from thermo.discover import (
    AbstractReadingCandidate,
    Candidate,
    Card,
    Place,
    Setting,
    Verdict,
    _bench,
    _discover,
    _path,
    _scoring,
    _standing,
    discover,
    forget,
    library,
    load_effects,
)
from thermo.discover._discover import blind_to, left_out
from thermo.discover._entries import Entry
from thermo.discover._scores import Score, ScoreTable
from thermo.discover.candidates import HeaterPower, HiddenSource
from thermo.errors import InputError
from thermo.inverse import Conditions, Meshing, Stepping, predict
from thermo.mesh import box_mesh
from thermo.observe import Recording, Run, Scene, read_scene
from thermo.report import discovery_record, write_discovery

MESHING, STEPPING = Meshing(max_nodes=1500), Stepping(tolerance=0.05)
# The block's own steps are wrong by some 10 mK; a camera of that noise does not see them.
NOISE = 0.1
SETTING = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 2700.0, 30.0, 290.0, 340.0)


@final
class WarmingCamera(AbstractReadingCandidate):
    """Somebody's own: a camera that reads more and more as it warms up."""

    card: ClassVar[Card] = Card(
        "warming_camera", "K/s", 0.1, -1.0, 1.0,
        excited_by="long runs", hides_behind="drift", split_by="a warm camera",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s]."""
        del under
        return temperature + self.strength[0] * jnp.maximum(time, 0.0)[:, None]


def few(setting: Setting) -> tuple[Candidate, ...]:
    """A small library: one program of three compiles sooner than that of all."""
    mesh = setting.mesh
    places = jnp.asarray(np.stack([mesh.nodes.mean(0), mesh.nodes.max(0)]))
    source = HiddenSource(jnp.zeros(2), Place(places, jnp.asarray([0.004, 0.004])))
    return source, HeaterPower(jnp.zeros(1)), WarmingCamera(jnp.zeros(1))


def noisy(run: Run, seed: int) -> Run:
    record, random = run.recording, np.random.default_rng(seed)
    assert record.quiet is not None
    data = record.temperature + NOISE * random.standard_normal(record.temperature.shape)
    quiet = record.quiet + NOISE * random.standard_normal(record.quiet.shape)
    return replace(run, recording=replace(record, temperature=data, quiet=quiet))


@pytest.fixture(scope="module", autouse=True)
def few_bricks() -> Iterator[None]:
    """All searches are on one mesh, the same on all machines, and share their programs."""
    with pytest.MonkeyPatch.context() as patch:
        lay_bricks(patch, (5, 3, 3))
        yield


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder: Path = write_block(tmp_path_factory.mktemp("block"))
    found = replace(read_scene(folder), unknown=("conductivity", "convection"))
    runs = {name: noisy(run, seed) for seed, (name, run) in enumerate(found.runs.items())}
    return replace(found, runs=runs)


@pytest.fixture(scope="module")
def weak(scene: Scene) -> Scene:
    """The scene with lamps that are said to be weaker than they are."""
    runs = dict(scene.runs)
    for name, run in scene.runs.items():
        if run.heater is not None:
            runs[name] = replace(run, heater=replace(run.heater, power=0.8 * run.heater.power))
    return replace(scene, runs=runs)


@pytest.fixture(scope="module")
def searched(weak: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Verdict, list[str]]:
    """What is found of weak lamps, and the work that it takes where pieces are kept."""
    with counted() as done:
        return asked(weak, tmp_path_factory.mktemp("whole")), done


@pytest.fixture(scope="module")
def named(searched: tuple[Verdict, list[str]]) -> Verdict:
    return searched[0]


@pytest.fixture(scope="module")
def clean(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Verdict, Path]:
    """What is found where nothing is missing, and where its pieces lie."""
    folder = tmp_path_factory.mktemp("pieces")
    return asked(scene, folder), folder


def asked(
    scene: Scene,
    checkpoint: Path | None = None,
    say: Callable[[str], None] = lambda words: None,
    error: float = 0.01,
) -> Verdict:
    return discover(
        scene, candidates=few, meshing=MESHING, stepping=STEPPING, model_error=error,
        checkpoint=checkpoint, say=say,
    )  # fmt: skip


def test_where_nothing_is_missing_nothing_is_named(
    scene: Scene, clean: tuple[Verdict, Path]
) -> None:
    found, _ = clean
    assert found.verdict == "no_gap" and found.effects() == [] and found.rounds == []
    assert found.omnibus[0] > 0.01 and found.omnibus[0] == found.omnibus[1]
    assert max(abs(one.score) for one in found.candidates) < found.threshold
    assert 2 < found.threshold < 3.5
    proof = found.held_out["test_lamp"]
    assert proof.rms_before == pytest.approx(proof.rms_after) and proof.gap_closed is None
    assert proof.rms_after == pytest.approx(NOISE, rel=0.1)
    # As long as the recording, without what fills it up beside longer ones.
    apart, read = proof.differences, scene.runs["test_lamp"].recording
    assert apart.before.shape == apart.after.shape == (len(apart.time), len(read.points))
    assert np.sqrt(np.nanmean(apart.after**2)) == pytest.approx(proof.rms_after)
    np.testing.assert_array_equal(apart.points, read.points)
    assert np.all(np.isin(np.round(apart.time, 9), np.round(read.time, 9)))
    assert min(one.slow for one in found.traces[0].values()) > 1e-3
    assert set(found.traces[0]["lamp"].inputs) == {"lamp", "temperature"}
    assert set(found.traces[0]["cooling"].inputs) == {"temperature"}
    # What could not have been missed is far below what another case hides.
    power = found.missed["heater_power"]
    least = power.strengths[0.8]
    assert least is not None and least < 0.1 and power.unit == "1"


def test_without_quiet_frames_what_samples_are_off_by_all_the_time_is_no_effect(
    scene: Scene,
) -> None:
    random, runs = np.random.default_rng(11), {}
    for name, run in scene.runs.items():
        record = run.recording
        off = 0.5 * random.standard_normal(len(record.points))
        read = record.temperature + off
        blind = Recording(record.points, record.time, read, record.valid)
        runs[name] = replace(run, recording=blind)
    found = asked(replace(scene, runs=runs))
    assert found.verdict == "no_gap" and found.omnibus[0] > 0.01
    told = [one for one in found.remarks if "has no quiet frames" in one]
    assert len(told) == 2 and all("samples are off by that" in one for one in told)
    proof = found.held_out["test_lamp"]
    assert proof.rms_after == pytest.approx(proof.noise, rel=0.1)


def test_a_lamp_of_another_power_is_named_by_how_much_it_is_off(
    scene: Scene, weak: Scene, named: Verdict, tmp_path: Path
) -> None:
    found = named
    assert found.verdict == "named" and found.effects() == ["heater_power"]
    (one,) = found.rounds
    assert one.together == ["heater_power"] and one.p_value < 1e-6 and one.closed > 0.9
    low, high = one.effect.interval95
    assert low < 0.25 < high and one.effect.strength == pytest.approx(0.25, rel=0.05)
    assert one.effect.centre is None and one.rms_after["lamp"] < 0.5 * one.rms_before["lamp"]
    (narrow,) = [told for told in found.remarks if told.startswith("Not looked for: ")]
    assert "void" in narrow and "heater_power" not in narrow
    proof = found.held_out["test_lamp"]
    assert proof.gap_closed is not None and proof.gap_closed > 0.95
    assert proof.rms_after == pytest.approx(NOISE, rel=0.1)
    assert found.omnibus[0] < 1e-6 < found.omnibus[1]
    assert "heater_power" in repr(found) and len(repr(found)) < 3000
    before, after = (one["lamp"].inputs["lamp"] for one in found.traces)
    assert before.p_value == 0.0 and abs(before.score) > 10
    assert after.p_value > 1e-3 and abs(after.score) < 5
    # What is left in the folder predicts as the verdict says.
    write_discovery(tmp_path, found, discovery_record(found) | {"object": "block", "seconds": 1.0})
    added = load_effects(tmp_path, scene, few)
    assert [one.card.name for one in added] == ["heater_power"]
    # Finer than a fit's, whose cells are wrong by half the noise.
    fine = Meshing(max_nodes=6000)
    again = predict(weak, tmp_path, meshing=fine, additions=added)["test_lamp"]
    assert again.scores["spatial"].rmse == pytest.approx(proof.rms_after, rel=0.1)
    bare = predict(weak, tmp_path, meshing=fine, additions=())["test_lamp"]
    assert bare.scores["spatial"].rmse > 2 * proof.rms_after
    for name, run in found.extended.runs.items():
        assert run.rmse == pytest.approx(one.rms_after[name])


@contextmanager
def counted() -> Iterator[list[str]]:
    """The names of all long pieces of work that are done within."""
    done: list[str] = []

    def counting(name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*words: Any, **more: Any) -> Any:
            made = work(*words, **more)
            done.append(name)
            return made

        return counted

    with pytest.MonkeyPatch.context() as patch:
        for room, name in [
            (_standing, "descend"), (_scoring, "signatures"), (_bench, "finer_temperatures"),
            (_bench, "readings"), (_path, "calibration"),
        ]:  # fmt: skip
            patch.setattr(room, name, counting(name, getattr(room, name)))
        yield done


class Stopped(Exception):
    """By a person, say."""


def test_an_interrupted_search_goes_on_to_the_same_verdict(
    weak: Scene, searched: tuple[Verdict, list[str]], tmp_path: Path
) -> None:
    named, whole = searched
    folder, told = tmp_path / "progress", discovery_record(named)
    said: list[str] = []

    def stop(words: str) -> None:
        said.append(words)
        if words.startswith("measuring the cells' error"):
            raise Stopped

    with counted() as before, pytest.raises(Stopped):
        asked(weak, folder, stop)
    with counted() as after:
        assert discovery_record(asked(weak, folder, said.append)) == told
    with counted() as none:
        again = asked(weak, folder)
    assert none == [] and discovery_record(again) == told
    for name, run in named.extended.runs.items():
        assert again.extended.runs[name].simulated.tobytes() == run.simulated.tobytes()
    # Nothing is done twice, and nothing is left out.
    assert sorted(before + after) == sorted(whole)
    assert set(before) == set(whole) - {"calibration"} and after.count("calibration") == 1
    assert 0 < before.count("descend") < whole.count("descend")
    assert any("left in this round" in words for words in said)
    assert any(re.match(r"put to work: heater_power 0\.\d+; lamp ", words) for words in said)

    # One that is damaged is made anew, and no other.
    file = next(folder.glob("fit-*"))
    file.write_bytes(file.read_bytes()[:-100])
    with counted() as mended:
        assert discovery_record(asked(weak, folder)) == told
    assert mended == ["descend"]
    forget(folder)
    assert not folder.exists()


def test_what_another_question_left_is_not_taken(
    weak: Scene, named: Verdict, clean: tuple[Verdict, Path]
) -> None:
    _, folder = clean
    with counted() as done:
        found = asked(weak, folder)
    assert discovery_record(found) == discovery_record(named)
    assert "descend" in done and "signatures" in done and "finer_temperatures" in done


def test_two_effects_are_both_named_and_their_strengths_are_those_of_one_fit(scene: Scene) -> None:
    runs = {}
    for name, run in scene.runs.items():
        record, heater = run.recording, run.heater
        data = record.temperature + 0.05 * record.time[:, None]
        less = None if heater is None else replace(heater, power=0.8 * heater.power)
        runs[name] = replace(run, heater=less, recording=replace(record, temperature=data))
    found = asked(replace(scene, runs=runs))
    assert found.verdict == "named" and len(found.rounds) == 2
    assert set(found.effects()) == {"heater_power", "warming_camera"}
    strengths = {one.effect.card.name: one.effect for one in found.rounds}
    # What one of them was fitted to alone lies far off; both together do not.
    assert strengths["heater_power"].strength == pytest.approx(0.25, rel=0.06)
    assert strengths["warming_camera"].strength == pytest.approx(0.05, rel=0.06)
    assert found.held_out["test_lamp"].rms_after == pytest.approx(NOISE, rel=0.1)


def test_kinds_of_the_library_that_are_left_out_are_told_of() -> None:
    every = library(SETTING)
    assert left_out(every, SETTING) == []
    assert left_out((*every, WarmingCamera(jnp.zeros(1))), SETTING) == []
    (told,) = left_out(every[2:], SETTING)
    assert f": {every[0].card.name}, {every[1].card.name}. An effect" in told


def test_kinds_that_no_reading_changes_with_are_told_of() -> None:
    cards = [one.card for one in library(SETTING)[:3]]
    entry = [
        Entry(kind, part, cards[kind], np.array([kind])) for kind in range(3) for part in (0, 1)
    ]
    scores = [Score(one, 1.0, np.ones(1), 1.0, 1.0, 0.1, slice(1)) for one in entry[:3]]
    none = np.zeros((0, 0))
    assert blind_to(ScoreTable(scores, [], 3.0, none, none)) == []
    # Of the second kind one part shows, of the third none.
    (told,) = blind_to(ScoreTable(scores, entry[3:], 3.0, none, none))
    assert f"with {cards[2].name}:" in told and cards[1].name not in told


def test_two_candidates_of_one_name_are_refused(scene: Scene) -> None:
    def twice(setting: Setting) -> tuple[Candidate, ...]:
        return (*few(setting), HeaterPower(jnp.zeros(1)))

    with pytest.raises(InputError, match="heater_power"):
        discover(scene, candidates=twice, meshing=MESHING, stepping=STEPPING)


def test_cells_that_are_wrong_by_more_than_noise_are_told_of() -> None:
    noise = {"lamp": 0.05, "cooling": 0.05}
    (said,) = _discover.rough({"lamp": 0.064, "cooling": 0.05}, noise)
    assert said.startswith("On lamp ") and "0.064 K, more than the noise, 0.05 K" in said
    assert "mesh.cells_per_depth" in said

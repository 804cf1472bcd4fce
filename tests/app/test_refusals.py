"""Bad command lines and bad files: exit code 2, one screen, and nothing half-written."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import numpy as np
import pytest
from box_scene import edit

from .conftest import SMALL, Command, Outcome


def check(outcome: Outcome, *parts: str) -> None:
    """One message with what was found, the limit and the remedy; `parts` stand in it."""
    assert outcome.code == 2, outcome
    # What is said of work that has begun stands above the message.
    said = outcome.err.removeprefix("fitting block: meshing\n")
    lines = said.strip().splitlines()
    assert 4 <= len(lines) <= 8 and max(map(len, lines)) < 400, outcome.err
    assert "Traceback" not in outcome.err
    for word in ("  found:  ", "  limit:  ", "  remedy: ", *parts):
        assert word in outcome.err, (word, outcome.err)


CHOICES = ["field", "optimiser", "integrator", "mesh", "stages", "prior"]


@pytest.mark.parametrize("group", CHOICES)
def test_an_unknown_choice_is_answered_with_those_there_are(
    group: str, command: Command, block: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = command("invert", f"data={block}", f"out={out}", f"{group}=nope")
    check(outcome, f"{group}/nope", "thermo invert --help")
    folder = Path(__file__).parents[2] / "conf" / group
    assert all(path.stem in outcome.err for path in folder.glob("*.yaml"))
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["bogus=1"], ["bogus"]),
        (["runs=lamp,cooling"], ["'runs=[lamp,cooling]'", "-m"]),
        (["runs=[lamp"], ["[lamp"]),
        (["runs=lamp"], ["runs", "lamp", "[a,b]"]),
        (["runs=[nope]"], ["unknown run", "nope", "lamp, cooling\n"]),
        (["runs=[test_lamp]"], ["held out", "runs.test_lamp"]),
        (["unknown=[nope]"], ["nope", "conductivity, diffusivity"]),
        (["unknown=[conductivity,diffusivity]"], ["same property"]),
        (["unknown=[]"], ["nothing is to be found"]),
        (["+field._target_=os.system"], ["field._target_", "os.system"]),
        (["optimiser.kind=os.system"], ["os.system", "lm, gauss_newton, lbfgs, adam"]),
        (["optimiser.max_steps=many"], ["optimiser.max_steps", "many"]),
        (["optimiser.max_steps=2.5"], ["2.5", "whole number"]),
        (["mesh.order=3"], ["mesh.order", "1 or 2"]),
        (["stages.kind=three"], ["three", "none, tet4_tet10"]),
        (["seed=few"], ["seed", "few"]),
        (["model_error=nan"], ["model_error", "nan"]),
        (["initial.conductivity=-1"], ["initial.conductivity", "-1"]),
        (["initial.conductivity=much"], ["initial.conductivity", "much"]),
        (["prior.step=0"], ["prior"]),
    ],
)
def test_a_bad_setting_is_refused(
    words: list[str], parts: list[str], command: Command, block: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = command("invert", f"data={block}", f"out={out}", *SMALL, *words)
    check(outcome, *parts)
    assert not out.exists() or list(out.iterdir()) == []


@pytest.mark.parametrize("verb", ["invert", "predict", "simulate"])
def test_what_must_be_given_is_named(verb: str, command: Command) -> None:
    check(command(verb), "Missing mandatory value", f"conf/{verb}.yaml")


def test_what_must_be_given_is_explained_with_its_unit(command: Command) -> None:
    outcome = command("register", "cameras=transforms.json")
    check(outcome, "ambient_temperature: a setting", "K, of the air", "ambient_temperature=VALUE")
    check(command("render", "data=x"), "run: a setting", "its run")


@pytest.mark.parametrize(
    "words", [("invert",), ("predict", "estimate=."), ("simulate", "run=lamp")]
)
def test_a_missing_folder_is_named(words: tuple[str, ...], command: Command) -> None:
    verb, *more = words
    check(command(verb, "data=no/such/folder", *more), "no/such/folder/scene.json", "no such file")


@pytest.mark.parametrize(
    "words", [("invert",), ("predict", "estimate=."), ("simulate", "run=lamp")]
)
@pytest.mark.parametrize("kind", ["file", "parent"])
def test_an_output_that_cannot_be_written_is_refused(
    kind: str, words: tuple[str, ...], command: Command, block: Path, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("something else")
    out = tmp_path / "taken" if kind == "file" else tmp_path / "taken" / "deeper"
    verb, *more = words
    check(command(verb, f"data={block}", f"out={out}", *more), "out", str(out))
    assert (tmp_path / "taken").read_text() == "something else"


def test_a_multirun_refuses_an_output_that_cannot_be_written(
    command: Command, block: Path, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("something else")
    out = tmp_path / "taken" / "deeper"
    check(command("invert", "-m", f"data={block}", f"out={out}", "seed=0,1"), str(out))


def test_a_full_disk_is_told_and_leaves_nothing_half_written(
    command: Command, block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "result.json")

    monkeypatch.setattr("thermo.app._verbs.inverse.invert", full)
    out = tmp_path / "out"
    check(command("invert", f"data={block}", f"out={out}"), "No space left", "out=FOLDER")
    assert list(out.iterdir()) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_refused(
    command: Command, block: Path, tmp_path: Path
) -> None:
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    check(command("invert", f"data={block}", f"out={locked / 'in'}"), str(locked))


def spoil(folder: Path, kind: str) -> None:
    file = folder / "lamp.npz"
    with np.load(file, allow_pickle=False) as stored:
        arrays = dict(stored)
    data = file.read_bytes()
    if kind == "truncated":
        file.write_bytes(data[: len(data) // 2])
    elif kind == "empty":
        file.write_bytes(b"")
    elif kind == "pickled":
        arrays["temperature"] = np.array([{"hidden": 1}], dtype=object)
        np.savez(file, **arrays)  # type: ignore[arg-type]
    elif kind == "celsius":
        np.savez(file, allow_pickle=False, **{**arrays, "temperature": arrays["temperature"] - 273})
    elif kind == "one frame":
        short = {"time": arrays["time"][:1], "temperature": arrays["temperature"][:1]}
        np.savez(file, allow_pickle=False, **{**arrays, **short})
    elif kind == "backwards":
        np.savez(file, allow_pickle=False, **{**arrays, "time": arrays["time"][::-1]})
    elif kind == "far":
        np.savez(file, allow_pickle=False, **{**arrays, "points": arrays["points"] + 1.0})
    elif kind == "surface":
        edit(folder, unit="m")
    elif kind == "scene":
        (folder / "scene.json").write_text('{"format": "thermofield-scene/1", ')


@pytest.mark.parametrize(
    ("kind", "place"),
    [
        ("truncated", "lamp.npz"), ("empty", "lamp.npz"), ("pickled", "lamp.npz"),
        ("celsius", "lamp.npz"), ("one frame", "lamp.npz"), ("backwards", "lamp.npz"),
        ("far", "runs.lamp"), ("surface", "block.ply"), ("scene", "scene.json"),
    ],
)  # fmt: skip
def test_a_spoiled_file_is_named(
    kind: str, place: str, command: Command, own: Path, cache: str, tmp_path: Path
) -> None:
    spoil(own, kind)
    out = tmp_path / "out"
    outcome = command("invert", f"data={own}", f"out={out}", cache, *SMALL)
    check(outcome, place)
    assert not out.exists() or list(out.iterdir()) == []


@pytest.mark.parametrize("kind", ["missing", "truncated", "pickled"])
def test_a_spoiled_estimate_is_named(
    kind: str, command: Command, block: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "estimate"
    folder.mkdir()
    if kind == "truncated":
        (folder / "estimate.npz").write_bytes(b"PK\x03\x04 and no more")
    elif kind == "pickled":
        np.savez(folder / "estimate.npz", format=np.array([{}], dtype=object))
    out = tmp_path / "out"
    outcome = command("predict", f"data={block}", f"estimate={folder}", f"out={out}")
    check(outcome, str(folder / "estimate.npz"), "thermo invert")
    assert list(out.iterdir()) == []


def test_unknown_runs_are_refused_by_every_verb(
    command: Command, block: Path, tmp_path: Path
) -> None:
    data = f"data={block}"
    check(command("simulate", data, "run=nope", f"out={tmp_path / 'a'}"), "nope", "test_lamp")
    words = ("predict", data, f"estimate={tmp_path}", "runs=[nope]", f"out={tmp_path / 'b'}")
    check(command(*words), "nope", "test_lamp")


def test_a_simulation_refuses_values_that_make_no_sense(
    command: Command, block: Path, own: Path, tmp_path: Path
) -> None:
    out = f"out={tmp_path / 'out'}"
    for value in ("-0.2", "nan", "warm"):
        words = ("simulate", f"data={block}", "run=lamp", out, f"material.conductivity={value}")
        check(command(*words), "conductivity", value)
    table = json.loads((own / "scene.json").read_text())["material"]
    edit(own, material={**table, "conductivity": None})
    check(command("simulate", f"data={own}", "run=lamp", out), "material.conductivity=0.2")


@pytest.mark.parametrize("words", [["melt"], ["inver", "data=."]])
def test_an_unknown_verb_is_answered_with_help(words: list[str], command: Command) -> None:
    outcome = command(*words)
    assert outcome.code == 2 and f"no verb '{words[0]}'" in outcome.err
    assert all(verb in outcome.err for verb in ("invert", "predict", "simulate"))


@pytest.mark.parametrize("words", [[], ["--help"], ["help"], ["--version"]])
def test_help_and_version_are_no_errors(words: list[str], command: Command) -> None:
    outcome = command(*words)
    assert outcome.code == 0 and outcome.err == ""
    assert ("thermo invert" in outcome.out) == (words != ["--version"])


@pytest.mark.parametrize(("verb", "key"), [("study", "presets"), ("ensemble", "folder")])
def test_help_lists_only_what_a_verb_takes(verb: str, key: str, command: Command) -> None:
    outcome = command(verb, "--help")
    assert outcome.code == 0 and f"{key}:" in outcome.out
    assert "integrator" not in outcome.out and "integrator" in command("invert", "--help").out


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["study"], ["give the name of a study: paper"]),
        (["study", "nonsense"], ["give the name of a study: paper", "nonsense"]),
        (["study", "paper", "data=nowhere"], ["data", "nowhere/cube", "data=FOLDER"]),
        (["study", "paper", "data=nowhere", "size=huge"], ["size", "huge", "quick, full"]),
        (["study", "paper", "data=nowhere", "rows=[cat-cooling]"], ["rows", "cat-cooling"]),
        (["study", "paper", "data=nowhere", "presets=best"], ["presets", "[a,b]"]),
        (["ensemble", "folder=nowhere"], ["nowhere", "no such folder", "thermo invert -m"]),
    ],
)
def test_a_study_and_an_ensemble_say_what_they_want(
    words: list[str], parts: list[str], command: Command
) -> None:
    outcome = command(*words)
    assert outcome.code == 2 and outcome.out == ""
    for part in parts:
        assert part in outcome.err
    assert list(Path.cwd().iterdir()) == []

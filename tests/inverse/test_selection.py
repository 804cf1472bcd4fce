"""Which runs and unknowns are taken, and names that are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from thermo.errors import InputError
from thermo.inverse._selection import select_fit_runs, select_runs, select_unknowns
from thermo.observe import Scene


def test_held_out_runs_are_predicted_and_never_fitted_by_default(scene: Scene) -> None:
    assert [run.name for run in select_fit_runs(scene, None)] == ["lamp", "cooling"]
    assert [run.name for run in select_runs(scene, None, held_out=True)] == ["test_lamp"]


def test_named_runs_keep_their_order_and_come_once(scene: Scene) -> None:
    names = ("cooling", "lamp", "cooling")
    assert [run.name for run in select_fit_runs(scene, names)] == ["cooling", "lamp"]


def test_a_held_out_run_is_not_fitted_even_by_name(scene: Scene) -> None:
    with pytest.raises(InputError, match="held out") as caught:
        select_fit_runs(scene, ("lamp", "test_lamp"))
    assert "runs.test_lamp" in caught.value.where and "predict" in caught.value.remedy


def test_an_unknown_run_is_named_with_those_there_are(scene: Scene) -> None:
    with pytest.raises(InputError, match="unknown run") as caught:
        select_runs(scene, ("lamp", "nope", "neither"), held_out=False)
    assert caught.value.value == "nope, neither"
    assert caught.value.limit == "lamp, cooling"
    assert "runs=[" in caught.value.remedy and str(scene.folder) in caught.value.where
    with pytest.raises(InputError, match="unknown run") as caught:
        select_runs(scene, ("nope",), held_out=True)
    assert caught.value.limit == "lamp, cooling, test_lamp"
    held = {name: replace(run, held_out=True) for name, run in scene.runs.items()}
    with pytest.raises(InputError, match="unknown run") as caught:
        select_runs(replace(scene, runs=held), ("nope",), held_out=False)
    assert caught.value.limit == "none: every run is held out"


def test_a_run_to_fit_is_meant_rather_than_one_that_is_held_out(scene: Scene) -> None:
    lamp = scene.runs["lamp"]
    flux = {f"flux_{n}": replace(lamp, name=f"flux_{n}", held_out=n == "30_R2") for n in FLUXES}
    for held_out, wrong, near in [
        (False, "flux_30_R3", "flux_30_R1"),
        (False, "flux_50_R2", "flux_50_R1"),
        (True, "flux_30_R2x", "flux_30_R2"),
    ]:
        with pytest.raises(InputError, match="unknown run") as caught:
            select_runs(replace(scene, runs=flux), (wrong,), held_out=held_out)
        assert f"did you mean {near}?" in caught.value.remedy


FLUXES = ("30_R2", "30_R1", "50_R1")


@pytest.mark.parametrize("names", [(), None])
def test_nothing_to_work_on_is_refused(names: tuple[str, ...] | None, scene: Scene) -> None:
    fitted = {n: run for n, run in scene.runs.items() if run.held_out}
    with pytest.raises(InputError, match="no run is left") as caught:
        select_runs(replace(scene, runs=fitted), names, held_out=False)
    if names is None:
        assert caught.value.remedy == "set held_out to false in one of them, in scene.json"
        assert caught.value.value == "held_out: true in all of test_lamp"


def test_the_scene_says_what_is_unknown_unless_told(scene: Scene) -> None:
    assert select_unknowns(scene, None) == ("conductivity",)
    names = ("emissivity", "convection", "emissivity")
    assert select_unknowns(scene, names) == ("emissivity", "convection")


@pytest.mark.parametrize(
    ("names", "value"), [(("conductivty",), "conductivty"), ((), "an empty list")]
)
def test_an_unknown_quantity_is_refused(names: tuple[str, ...], value: str, scene: Scene) -> None:
    with pytest.raises(InputError) as caught:
        select_unknowns(scene, names)
    assert (caught.value.where, caught.value.value) == ("unknown", value)
    assert "conductivity, diffusivity" in caught.value.limit
    assert "unknown=[" in caught.value.remedy


def test_a_misspelt_name_is_told_by_its_right_one(scene: Scene) -> None:
    with pytest.raises(InputError) as caught:
        select_runs(scene, ("colling",), held_out=False)
    assert caught.value.remedy.startswith("did you mean cooling? ")
    with pytest.raises(InputError) as caught:
        select_unknowns(scene, ("conductivty",))
    assert caught.value.remedy.startswith("did you mean conductivity? ")

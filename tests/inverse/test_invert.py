"""Fits of the block, whose data another code made on another mesh with other steps."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from box_scene import CONDUCTIVITY, NOISE, edit

from thermo.errors import InputError
from thermo.fields import QUANTITIES, DirectField, TwoMaterialField, place_control_points
from thermo.inverse import (
    Adam,
    Estimate,
    Meshing,
    OnControlPoints,
    Prior,
    Stepping,
    TwoMaterials,
    Uniform,
    invert,
)
from thermo.inverse import _invert as module
from thermo.inverse._invert import _flash, _twice, _unmoved, at_bounds
from thermo.inverse._smoothing import ALL_BUT_UNIFORM
from thermo.mesh import box_mesh
from thermo.observe import Recording, Scene, read_scene
from thermo.physics.integrators import BackwardEuler

from .conftest import START
from .walk import Walk

pytestmark = pytest.mark.usefixtures("bricks")

LONG = Stepping(integrator=BackwardEuler(), size=1.5)
TWO = ("lamp", "cooling")


def descend(data: Path | Scene, meshing: Meshing, **more: Any) -> Estimate:
    """Four epochs on two runs: every call runs the same compiled program."""
    return invert(
        data, runs=TWO, initial=START, optimiser=Adam(max_steps=4, rate=0.2), stepping=LONG,
        meshing=meshing, choice=Uniform(), **more,
    )  # fmt: skip


def stroll(data: Path | Scene, meshing: Meshing, **more: Any) -> Estimate:
    """A fit that never simulates."""
    settings: dict[str, Any] = {"initial": START, "stepping": LONG, "meshing": meshing}
    settings |= {"optimiser": Walk(), "choice": Uniform()}
    return invert(data, **{**settings, **more})


@pytest.fixture
def unsimulated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the simulation of the runs at the end of a fit."""
    monkeypatch.setattr(module, "run_fits", lambda *_: {})


@pytest.fixture(scope="module")
def plain(block: Path, meshing: Meshing) -> Estimate:
    return descend(block, meshing)


def test_uniform_conductivity_from_two_shared_runs(fitted: Estimate) -> None:
    field = fitted.fields["conductivity"]
    assert np.ptp(field.cells) == 0 and field.unit == "W/m/K"
    assert field.cells[0] == field.faces[0] == pytest.approx(CONDUCTIVITY, rel=0.02)
    assert abs(field.cells[0] / START["conductivity"] - 1) > 0.6, "it came a long way"
    assert fitted.success and fitted.order == 2
    assert len(fitted.history[0]) <= 12


def test_only_runs_that_are_not_held_out_were_fitted(fitted: Estimate, scene: Scene) -> None:
    assert list(fitted.runs) == ["lamp", "cooling"]
    for name, run in fitted.runs.items():
        recording = scene.runs[name].recording
        assert np.array_equal(run.points, recording.points)
        picked = np.searchsorted(recording.time, run.time - 1e-9)
        assert np.array_equal(np.isfinite(run.measured), recording.valid[picked])
        difference = (run.simulated - run.measured)[np.isfinite(run.measured)]
        assert run.rmse == pytest.approx(np.sqrt(np.mean(difference**2)), rel=1e-9)
        # Meshes differ: cells this coarse are wrong by 0.04 to 0.07 K under a lamp.
        assert 0.8 * NOISE < run.rmse < 0.1


def test_what_a_sample_reads_wrong_all_the_time_is_no_residual(
    scene: Scene, meshing: Meshing
) -> None:
    run = scene.runs["lamp"]
    record = run.recording
    off = np.linspace(-3.0, 3.0, len(record.points))

    def rmse(shift: float, stated: float) -> float:
        read = np.where(record.valid, record.temperature + shift * off, np.nan)
        shifted = Recording(record.points, record.time, read)
        alone = {"lamp": replace(run, recording=shifted, constant_error=stated)}
        estimate = stroll(replace(scene, runs=alone), meshing, runs=("lamp",))
        return estimate.runs["lamp"].rmse

    told = rmse(1.0, 4.0)
    assert told == pytest.approx(rmse(0.0, 4.0), rel=0.02)
    assert rmse(1.0, 0.0) > 1.2 * told


def test_the_fit_says_how_well_the_skin_is_resolved(fitted: Estimate) -> None:
    assert "mm deep" in fitted.resolution and fitted.seconds > 0


def test_a_descent_lowers_the_loss(plain: Estimate) -> None:
    (history,) = plain.history
    assert len(history) == 4 and np.all(np.diff(history) < 0)
    assert plain.fields["conductivity"].cells[0] < START["conductivity"]


def test_truth_is_never_read(own: Path, plain: Estimate, meshing: Meshing) -> None:
    edit(own, truth={"conductivity": -1e30, "field": "no-such-file.npz", "unit": ["nonsense"]})
    again = descend(own, meshing)
    assert again.history == plain.history
    mine, theirs = again.fields["conductivity"], plain.fields["conductivity"]
    assert np.array_equal(mine.cells, theirs.cells)
    for name in TWO:
        mine, theirs = again.runs[name].simulated, plain.runs[name].simulated
        assert np.array_equal(mine, theirs, equal_nan=True)


def test_the_held_out_run_does_not_enter(own: Path, plain: Estimate, meshing: Meshing) -> None:
    shutil.copy(own / "lamp.npz", own / "test_lamp.npz")
    assert descend(own, meshing).history == plain.history


@pytest.mark.parametrize("after", [1, 3])
def test_an_interrupted_fit_goes_on_as_if_it_had_not_been(
    after: int, block: Path, plain: Estimate, meshing: Meshing, tmp_path: Path
) -> None:
    file = tmp_path / "checkpoint.npz"

    def stop(number: int, most: int, value: float) -> None:
        if number == after:
            raise KeyboardInterrupt

    said: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        descend(block, meshing, checkpoint=file, on_step=stop, say=said.append)
    nodes = f"a mesh of {len(plain.mesh.nodes)} nodes"
    assert said[0] == "fitting block: meshing" and nodes in said[1]
    told: list[int] = []
    resumed = descend(
        block, meshing, checkpoint=file, on_step=lambda n, *_: told.append(n), say=said.append
    )
    assert told == list(range(after + 1, 5))
    assert said[2] == f"going on from {file}, if it is of this fit: meshing"
    assert np.allclose(resumed.history[0], plain.history[0], rtol=1e-10, atol=0)
    mine, theirs = resumed.fields["conductivity"], plain.fields["conductivity"]
    assert np.allclose(mine.cells, theirs.cells, rtol=1e-10, atol=0)
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.usefixtures("unsimulated")
def test_the_second_stage_starts_from_exactly_the_first_ones_field(
    block: Path, meshing: Meshing
) -> None:
    walk = Walk()
    quadratic = replace(meshing, order=2)
    fixed = Prior(step=0.3)
    choice = OnControlPoints(count=4)
    estimate = stroll(block, quadratic, optimiser=walk, choice=choice, prior=fixed)
    first, second = walk.seen[:3], walk.seen[3:]
    assert [np.shape(o.space.mesh.cells)[1] for o, _ in first] == [4, 4, 4]
    assert [np.shape(o.space.mesh.cells)[1] for o, _ in second] == [10, 10, 10]
    # The same field on the same linear mesh: the parameters mean the same.
    one, other = (o.fields["conductivity"] for o, _ in (first[0], second[0]))
    assert isinstance(one, DirectField) and isinstance(other, DirectField)
    pairs = zip(jax.tree.leaves(one.extension), jax.tree.leaves(other.extension), strict=True)
    assert all(np.array_equal(mine, theirs) for mine, theirs in pairs)
    left = np.asarray(first[-1][1]["conductivity"]) + 0.1
    assert np.array_equal(np.asarray(second[0][1]["conductivity"]), left)
    assert estimate.order == 2 and len(estimate.history) == 2


@pytest.mark.usefixtures("unsimulated")
@pytest.mark.parametrize("after", [2, 4])
def test_two_materials_go_on_from_either_stage(
    after: int, block: Path, meshing: Meshing, tmp_path: Path
) -> None:
    ready = stroll(block, meshing, optimiser=Walk(max_steps=1), choice=OnControlPoints(count=12))
    along = place_control_points(ready.mesh, 12).points[:, 0]
    rise = tuple(np.where(along > np.median(along), 0.5, 0.1))

    def fit(walk: Walk, **more: Any) -> Estimate:
        return stroll(block, meshing, optimiser=walk, choice=TwoMaterials(count=12), **more)

    walk = Walk(first=rise)
    whole = fit(walk)
    assert isinstance(walk.seen[0][0].fields["conductivity"], DirectField)
    assert isinstance(walk.seen[-1][0].fields["conductivity"], TwoMaterialField)
    assert [len(losses) for losses in whole.history] == [3, 3]

    def stop(number: int, most: int, value: float) -> None:
        if number == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(Walk(first=rise), checkpoint=tmp_path / "fit.npz", on_step=stop)
    told: list[int] = []
    resumed = fit(
        Walk(first=rise), checkpoint=tmp_path / "fit.npz", on_step=lambda n, *_: told.append(n)
    )
    assert told == list(range(after + 1, 7)) and resumed.history == whole.history
    mine, theirs = resumed.fields["conductivity"], whole.fields["conductivity"]
    assert np.array_equal(mine.cells, theirs.cells) and np.ptp(mine.cells) > 0.1


@pytest.mark.usefixtures("unsimulated")
@pytest.mark.parametrize(
    "other", [{"seed": 1}, {"model_error": 0.02}, {"initial": {"conductivity": 2.0}}, {"data": 1}]
)
def test_a_checkpoint_is_not_taken_up_by_another_question(
    other: dict[str, Any], scene: Scene, meshing: Meshing, tmp_path: Path
) -> None:
    file = tmp_path / "checkpoint.npz"

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stroll(scene, meshing, checkpoint=file, on_step=stop)
    if "data" in other:
        run = scene.runs["cooling"]
        cooler = replace(run, initial_temperature=run.initial_temperature - 1.0)
        scene, other = replace(scene, runs={**scene.runs, "cooling": cooler}), {}
    with pytest.raises(InputError, match="belongs to another fit"):
        stroll(scene, meshing, checkpoint=file, **other)
    assert file.exists()


@pytest.mark.usefixtures("unsimulated")
def test_a_conductivity_that_nobody_states_is_looked_for(own: Path, meshing: Meshing) -> None:
    table = {"name": "epoxy", "density": 1100.0, "heat_capacity": 1400.0, "conductivity": None}
    scene = read_scene(edit(own, material=table))
    found = stroll(scene, meshing, runs=("lamp",), initial=None)
    assert found.stated.conductivity == 1.0, "of 0.03, 0.1, 0.3, 1, 3, ... the nearest to 0.8"


@pytest.mark.parametrize("value", [-1.0, 0.0, float("nan"), float("inf")])
def test_an_initial_value_that_makes_no_sense_is_refused(value: float, scene: Scene) -> None:
    with pytest.raises(InputError, match="not positive") as caught:
        invert(scene, initial={"conductivity": value})
    assert caught.value.where == "initial.conductivity"


@pytest.mark.parametrize("value", [1e-9, 9000.0])
def test_a_first_value_beyond_its_bounds_is_refused(value: float, scene: Scene) -> None:
    with pytest.raises(InputError, match="beyond where it is looked for") as caught:
        invert(scene, initial={"conductivity": value})
    assert caught.value.where == "initial.conductivity" and "W/m/K" in caught.value.limit


def test_names_are_checked_before_any_work(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def worked(*_: object) -> None:
        raise AssertionError("work began")

    monkeypatch.setattr(module, "prepare", worked)
    wrong: list[dict[str, Any]] = [
        {"runs": ("nope",)},
        {"runs": ("test_lamp",)},
        {"unknown": ("nope",)},
        {"unknown": ("conductivity", "diffusivity")},
    ]
    for more in wrong:
        with pytest.raises(InputError):
            invert(scene, **more)


def test_the_data_call_one_material_uniform(
    block: Path, meshing: Meshing, stepping: Stepping
) -> None:
    # Until the field begins its programs are those of `fitted`.
    quadratic = replace(meshing, order=2, corrected=True)
    choice = OnControlPoints(count=12)
    how = {"meshing": quadratic, "stepping": stepping, "choice": choice}
    estimate = invert(block, initial=START, **how)
    field = estimate.fields["conductivity"]
    # What a mesh of so few cells leaves wrong can look like two per cent of variation.
    step = estimate.smoothness["conductivity"]
    assert step <= 0.02
    said = "no variation of conductivity" if step <= ALL_BUT_UNIFORM else "a factor of about 1.0"
    assert any(said in remark for remark in estimate.remarks)
    assert np.ptp(field.faces) < 0.02 * CONDUCTIVITY
    assert float(np.median(field.faces)) == pytest.approx(CONDUCTIVITY, rel=0.02)
    # One value on linear cells, on quadratic ones, and without their errors; then the field, and
    # once more where the choice changed.
    assert 4 <= len(estimate.history) <= 5
    assert any("is allowed for" in remark for remark in estimate.remarks)
    for run in estimate.runs.values():
        assert run.deviation >= np.hypot(run.noise, 0.01) * (1 - 1e-9)


@pytest.mark.usefixtures("unsimulated")
def test_a_fit_says_that_it_could_not_be_corrected(
    block: Path, meshing: Meshing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("thermo.inverse._stages.less_defects", lambda *asked: asked[2])
    how = {"runs": ("lamp",), "optimiser": Walk(fixed=False)}
    estimate = stroll(block, replace(meshing, corrected=True), **how)
    assert any("could not be made" in remark for remark in estimate.remarks)
    estimate = stroll(block, meshing, **how)
    assert not any("could not be made" in remark for remark in estimate.remarks)


@pytest.mark.usefixtures("unsimulated")
@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("conductivity", 4887.0, "100 % of conductivity came to its bound, 5000 W/m/K"),
        ("conductivity", 4000.0, ""),
        ("convection", 0.0102, "100 % of convection came to its bound, 0.01 W/m2/K"),
        ("emissivity", 0.98, ""),  # paint
        ("emissivity", 0.00101, "100 % of emissivity came to its bound, 0.001"),
    ],
)
def test_a_value_at_its_bound_is_told(name: str, value: float, told: str) -> None:
    mesh = box_mesh((0.02, 0.02, 0.008), (2, 2, 1))
    field, _ = Uniform().make(QUANTITIES[name], mesh, value, 0)
    found = at_bounds({name: field})
    assert len(found) == bool(told) and all(told in one for one in found)


def test_a_value_that_nothing_moved_is_told() -> None:
    mesh = box_mesh((0.02, 0.02, 0.008), (2, 2, 1))
    first, _ = Uniform().make(QUANTITIES["emissivity"], mesh, 0.85, 0)
    pushed, _ = Uniform().make(QUANTITIES["emissivity"], mesh, 0.85001, 0)
    (told,) = _unmoved({"emissivity": first}, {"emissivity": first})
    assert told.startswith("emissivity stayed at its first value")
    assert _unmoved({"emissivity": first}, {"emissivity": pushed}) == []


def test_readings_that_count_twice_are_told_of(scene: Scene) -> None:
    lamp, cooling = scene.runs["lamp"], scene.runs["cooling"]
    assert _twice([lamp, cooling]) == []
    (told,) = _twice([lamp, cooling, replace(lamp, name="again")])
    assert told.startswith("lamp and again hold the same readings")


def test_a_lamp_that_is_off_before_the_second_frame_is_told(scene: Scene) -> None:
    run = scene.runs["lamp"]
    assert run.heater is not None and _flash(run) == _flash(scene.runs["cooling"]) == ""
    record, scale = run.recording, 1000.0 * run.heater.until
    slow = Recording(record.points, scale * record.time, record.temperature)
    assert f"off at {run.heater.until:g} s" in _flash(replace(run, recording=slow))


def test_a_start_scales_first_values_and_nothing_else(block: Path, meshing: Meshing) -> None:
    seen = []
    for start in (1.0, 3.0):
        walk = Walk()
        stroll(block, meshing, optimiser=walk, start=start)
        seen.append(walk.seen[0][0])
    plain, moved = seen
    values = [float(o.fields["conductivity"].control_values()[0]) for o in seen]
    assert values == pytest.approx([START["conductivity"], 3 * START["conductivity"]], rel=1e-9)
    assert np.array_equal(plain.space.mesh.nodes, moved.space.mesh.nodes)
    assert plain.stated == moved.stated
    assert float(plain.priors["conductivity"].centre) == float(moved.priors["conductivity"].centre)


def test_a_first_value_of_what_is_no_quantity_is_refused(block: Path) -> None:
    with pytest.raises(InputError, match="there is no such quantity") as caught:
        invert(block, initial={"k": 1.0})
    assert caught.value.where == "initial.k" and "conductivity" in str(caught.value.limit)


@pytest.mark.parametrize("start", [0.0, -1.0, float("nan"), float("inf")])
def test_a_start_that_is_no_factor_is_refused(start: float, block: Path) -> None:
    with pytest.raises(InputError, match="a start is no factor") as caught:
        invert(block, start=start)
    assert caught.value.where == "start"

"""One function a verb: from a configuration to a folder of results."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from thermo import inverse
from thermo.app._configuration import (
    build_field,
    build_meshing,
    build_optimiser,
    build_prior,
    build_stepping,
    given,
    names,
    number,
    size,
    stages,
)
from thermo.app._fitted import left_by_search, unexplained_by
from thermo.app._scene import scene_of
from thermo.discover import load_effects, stated_otherwise
from thermo.observe import Scene, estimate_noise, read_scene
from thermo.report import (
    Progress,
    cells_wrong,
    inversion_table,
    prediction_table,
    require_writable,
    say_to,
    table,
    write_inversion,
    write_json,
    write_predictions,
)
from thermo.study import ensemble_record, gather, paper_cases, read_members
from thermo.study import study as study_cases

Configuration = Mapping[str, Any]


def invert(settings: Configuration) -> None:
    """Fit, and leave `result.json`, `field.npz`, `estimate.npz`, `field.vtu` and figures."""
    out = Path(settings["out"])
    arguments = {
        "choice": build_field(settings["field"]),
        "optimiser": build_optimiser(settings["optimiser"]),
        "prior": build_prior(settings["prior"]),
        "stepping": build_stepping(settings["integrator"]),
        "meshing": build_meshing(settings["mesh"]),
        "runs": names(settings["runs"], "runs"),
        "unknown": names(settings["unknown"], "unknown"),
        "stages": stages(settings["stages"]),
        "initial": given(settings["initial"], "initial."),
        "start": number(settings, "init", above=0.0),
        "seed": number(settings, "seed", whole=True),
        "model_error": number(settings, "model_error", above=0.0),
    }
    scene, dropped = scene_of(settings)
    require_writable(out)
    checkpoint = out / "checkpoint.npz"
    with Progress("invert", None, sys.stderr) as progress:
        estimate = inverse.invert(
            scene,
            checkpoint=checkpoint,
            on_step=lambda step, about, loss: progress.update(step, loss, about),
            say=say_to(sys.stderr),
            **arguments,
        )
    record = write_inversion(out, estimate, settings, dropped)
    checkpoint.unlink(missing_ok=True)
    print(inversion_table(record))
    ended = _ending(estimate, arguments["optimiser"])
    remarks = "".join(f"\n{remark}" for remark in estimate.remarks)
    print(
        f"\n{ended} {estimate.resolution}{remarks}\n{out / 'result.json'}, {estimate.seconds:.0f} s"
    )


def _ending(estimate: inverse.Estimate, optimiser: inverse.AbstractOptimiser) -> str:
    steps = sum(len(losses) for losses in estimate.history)
    if optimiser.fixed_length():
        return f"Made all {steps} steps."
    if estimate.success:
        return f"Settled after {steps} steps."
    remedy = "the coarse tangents know no way down, give mesh.coarse_tangents=false"
    if len(estimate.history[-1]) >= optimiser.max_steps:
        remedy = "raise optimiser.max_steps, or see by `thermo identify` what these runs leave open"
    return f"NOT CONVERGED after {steps} steps: {remedy}."


def predict(settings: Configuration) -> None:
    """Predict, and leave `result.json`, a recording and a ParaView series for each run."""
    begun = time.monotonic()
    out = Path(settings["out"])
    scene = read_scene(Path(settings["data"]))
    require_writable(out)
    estimate = Path(settings["estimate"])
    finished = (estimate / "estimate.npz").exists()
    effects = load_effects(estimate, scene) if finished else None
    predictions = inverse.predict(
        scene,
        estimate,
        additions=effects,
        runs=names(settings["runs"], "runs"),
        meshing=build_meshing(settings["mesh"]),
        tolerance=number(settings, "tolerance", above=0.0),
        say=say_to(sys.stderr),
    )
    seconds = time.monotonic() - begun
    taken = [one.card.name for one in effects or ()]
    mesh, _, _, fields = inverse.load_estimate(estimate / "estimate.npz")
    noise = _noise(scene, predictions)
    coarse = _of_cells(predictions, noise)
    remarks = [*stated_otherwise(estimate, scene), *_of_the_fit(estimate), *coarse]
    record = write_predictions(
        out, "predict", predictions, settings, seconds, taken, remarks,
        noise=noise, mesh=mesh, fields=fields,
    )  # fmt: skip
    beside = f"\nEffects beside the stated ones: {', '.join(taken)}." if taken else ""
    told = beside + "".join(f"\n{remark}" for remark in remarks)
    print(f"{prediction_table(record)}\n{told}\n{out / 'result.json'}, {seconds:.0f} s")


def _noise(scene: Scene, runs: Iterable[str]) -> dict[str, float]:
    """Of a reading, by run, as its recording tells it [K]."""
    return {name: estimate_noise(scene.runs[name].recording).total() for name in runs}


def _of_cells(made: Mapping[str, inverse.Prediction], noise: Mapping[str, float]) -> list[str]:
    """A sentence for each run in which cells make more wrong in some frame than noise does [K]."""
    told = []
    for run, one in made.items():
        if one.cells is None or one.cells.max() <= noise[run]:
            continue
        wrong = cells_wrong(one.time, one.cells)
        told.append(
            f"Cells make some {wrong['largest']:.2g} K wrong in {run} at {wrong['time']:.3g} s, "
            f"{wrong['rms']:.2g} K over all frames (RMS), where noise is {noise[run]:.2g} K: "
            "a larger mesh.cells_per_depth or mesh.max_nodes makes that less."
        )
    return told


def _of_the_fit(folder: Path) -> list[str]:
    told = [f"Of the fit that this rests on: {one}" for one in unexplained_by(folder)]
    return [*told, *left_by_search(folder)]


def study(settings: Configuration) -> None:
    """Study the paper's scenes, and leave a record a case, tables and figures."""
    out = Path(settings["out"])
    cache = settings["mesh_cache"]
    cases = paper_cases(
        Path(settings["data"]),
        parts=names(settings["parts"], "parts"),
        rows=names(settings["rows"], "rows"),
        presets=names(settings["presets"], "presets") or (),
        noises=names(settings["noise"], "noise") or (),
        size=size(settings["size"]),
        cache=None if cache is None else Path(cache),
    )
    require_writable(out)
    print(f"{len(cases)} fits, beginning with {cases[0].name()}", file=sys.stderr)
    with Progress("study", len(cases), sys.stderr) as progress:
        _, text = study_cases(cases, out, on_case=progress.update)
    print(f"{text}\n\n{out / 'tables.md'}")


def ensemble(settings: Configuration) -> None:
    """Gather the fits of a sweep, and leave `ensemble.json` in its folder."""
    folder = Path(settings["folder"])
    members, units = read_members(folder)
    found = gather(members, units)
    rows = [
        [name, item.unit, item.members, item.median, 100 * item.deviation, 100 * item.width,
         None if item.split is None else 100 * item.split.share(), item.final_error]
        for name, item in found.items()
    ]  # fmt: skip
    write_json(folder / "ensemble.json", ensemble_record(members, found))
    header = ["field", "unit", "fits", "median", "deviation [%]", "width [%]",
              "share of the start [%]", "final error [K]"]  # fmt: skip
    whole = all(item.split is not None for item in found.values())
    gap = "" if whole else "\nThe variance is not split: not every start has the same seeds."
    print(f"{table(rows, header)}\n{gap}\n{folder / 'ensemble.json'}")


def simulate(settings: Configuration) -> None:
    """Simulate, and leave the same files as `predict`."""
    begun = time.monotonic()
    out = Path(settings["out"])
    meshing = build_meshing(settings["mesh"])
    scene = read_scene(Path(settings["data"]))
    require_writable(out)
    material = given(settings["material"], "material.")
    exchange = given(settings["surface_exchange"], "surface_exchange.")
    density = material.pop("density", scene.material.density)
    stated = scene.material.volumetric_heat_capacity() / scene.material.density
    capacity = density * material.pop("heat_capacity", stated)
    prediction = inverse.simulate(
        scene,
        str(settings["run"]),
        values={**material, **exchange, "volumetric_heat_capacity": capacity},
        meshing=meshing,
        tolerance=number(settings, "tolerance", above=0.0),
        say=say_to(sys.stderr),
    )
    seconds = time.monotonic() - begun
    runs = {str(settings["run"]): prediction}
    noise = _noise(scene, runs)
    remarks = _of_cells(runs, noise)
    record = write_predictions(
        out, "simulate", runs, settings, seconds, remarks=remarks, noise=noise
    )
    told = "".join(f"\n{remark}" for remark in remarks)
    print(f"{prediction_table(record)}\n{told}\n{out / 'result.json'}, {seconds:.0f} s")

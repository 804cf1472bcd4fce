"""Which runs and unknowns a verb works on."""

from __future__ import annotations

from thermo.errors import InputError, meant
from thermo.fields import QUANTITIES
from thermo.observe import Run, Scene


def select_runs(scene: Scene, names: tuple[str, ...] | None, *, held_out: bool) -> list[Run]:
    """The named runs, or all that are held out or not [1].

    Raises `InputError` for a name that the scene does not have, and where nothing is left.
    """
    if names is None:
        picked = [run for run in scene.runs.values() if run.held_out == held_out]
        names = tuple(run.name for run in picked)
        if not names:
            wanted, other = ("true", "false") if held_out else ("false", "true")
            raise InputError(
                "no run is left to work on", where=f"{scene.folder}: runs",
                value=f"held_out: {other} in all of {', '.join(scene.runs)}",
                limit=f"at least one run with held_out: {wanted}",
                remedy=f"set held_out to {wanted} in one of them, in scene.json",
            )  # fmt: skip
    unknown = [name for name in names if name not in scene.runs]
    if unknown or not names:
        # What is to be fitted is hardly a run that is held out.
        likely = [name for name, run in scene.runs.items() if held_out or not run.held_out]
        first = "".join(unknown[:1])
        near = meant(first, likely) or meant(first, scene.runs)
        raise InputError(
            "unknown run" if unknown else "no run is left to work on",
            where=f"{scene.folder}: runs",
            value=", ".join(unknown) or "none",
            limit=", ".join(likely) or "none: every run is held out",
            remedy=f"{near}name runs of the scene, as runs=[a,b]",
        )
    return [scene.runs[name] for name in dict.fromkeys(names)]


def select_fit_runs(scene: Scene, names: tuple[str, ...] | None) -> list[Run]:
    """Runs to fit [1]: as `select_runs`, and never a held-out one.

    Raises `InputError` for an unknown or a held-out run.
    """
    runs = select_runs(scene, names, held_out=False)
    for run in runs:
        if run.held_out:
            raise InputError(
                "this run is held out and must not be fitted",
                where=f"{scene.folder}: runs.{run.name}",
                value="held_out: true",
                limit="runs that are not held out",
                remedy="predict it, or set held_out to false in scene.json",
            )
    return runs


def select_unknowns(scene: Scene, names: tuple[str, ...] | None) -> tuple[str, ...]:
    """The named unknowns, or the scene's own [1].

    Raises `InputError` for a name that is no quantity, and where there is none.
    """
    names = scene.unknown if names is None else names
    wrong = [name for name in names if name not in QUANTITIES]
    if wrong or not names:
        near = meant("".join(wrong[:1]), QUANTITIES)
        raise InputError(
            "this quantity cannot be fitted" if wrong else "nothing is to be found",
            where="unknown",
            value=", ".join(wrong) or "an empty list",
            limit=", ".join(QUANTITIES),
            remedy=f"{near}give unknown=[conductivity], for example",
        )
    return tuple(dict.fromkeys(names))

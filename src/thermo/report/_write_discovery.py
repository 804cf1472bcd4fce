"""What a search for missing effects leaves in its folder."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from thermo.discover import (
    Alternative,
    Calibration,
    Candidacy,
    Differences,
    Effect,
    HeldOut,
    Misfit,
    Round,
    Trace,
    Verdict,
    effects_as_arrays,
)
from thermo.fields import QUANTITIES
from thermo.inverse import RunFit, save_estimate

from ._discovery_page import discovery_page
from ._json import write_json
from ._passed_limit import passed_limit
from ._table import table
from ._text import write_text
from ._versions import versions

# The share of cases whose strength stands for the others [1].
_MOSTLY: Final = 0.8
# Depth over which a support reaches up from a side, over how wide that is, that is nothing [1].
_FLAT: Final = 0.01


def discovery_record(found: Verdict) -> dict[str, Any]:
    """Every number of a verdict as plain data: values [SI], temperatures [K], scores [1]."""
    return {
        "format": "thermofield-verdict/1",
        "verb": "discover",
        "verdict": found.verdict,
        "sentences": verdict_sentences(found),
        "effects": found.effects(),
        "rounds": [_round(one, bool(found.effects())) for one in found.rounds],
        "candidates": [_candidacy(one) for one in found.candidates],
        "threshold": found.threshold,
        "alias": {name: dict(row) for name, row in found.alias.items()},
        "held_out": {
            name: {
                "rms_before": one.rms_before,
                "rms_after": one.rms_after,
                "noise": one.noise,
                "gap_closed": one.gap_closed,
                "gap_closed_interval95": None if one.interval95 is None else list(one.interval95),
            }
            for name, one in found.held_out.items()
        },
        "numerics": {"cells_and_steps_K": dict(found.cells)},
        "noise": dict(found.noise),
        "parameters": {
            name: {
                "before": before,
                "after": after,
                "interval95": list(found.intervals[name]) if name in found.intervals else None,
            }
            for name, (before, after) in found.parameters.items()
        },
        "p_value": {"without": found.omnibus[0], "with": found.omnibus[1]},
        "gap": {
            name: {"before": _misfit(one), "after": _misfit(found.misfits[1][name])}
            for name, one in found.misfits[0].items()
        },
        "over_time": {
            name: {"before": _trace(one), "after": _trace(found.traces[1][name])}
            for name, one in found.traces[0].items()
        },
        "residuals": _residuals(found),
        "calibration": _calibration(found.calibration),
        "could_have_missed": {
            name: {
                "strength": one.strengths[_MOSTLY],
                "unit": one.unit,
                "found_in": {f"{share:g}": found for share, found in one.strengths.items()},
            }
            for name, one in found.missed.items()
        },
        "remarks": found.remarks,
        "versions": versions(),
    }


def _misfit(one: Misfit) -> dict[str, dict[str, float]]:
    parts = {"steady": one.steady, "changing": one.changing, "rest": one.rest}
    return {
        name: {"squares": part.squares, "expected": part.expected} for name, part in parts.items()
    }


def _trace(one: Trace) -> dict[str, Any]:
    inputs = {
        name: {"score": each.score, "lag_s": each.lag, "p_value": each.p_value}
        for name, each in one.inputs.items()
    }
    return {"slow_p_value": one.slow, "follows": inputs}


def _residuals(found: Verdict) -> dict[str, Any]:
    """By run and sample [m], and by run and frame [s], root mean squares before and after [K].

    Of runs that were fitted and, after them, of those that were not: there as well with what is
    closest, where nothing explains the gap.
    """
    fitted = {
        name: Differences(one.time, one.points, _apart(one), _apart(found.extended.runs[name]))
        for name, one in found.stated.runs.items()
    }
    others = {name: one.differences for name, one in found.held_out.items()}
    return {
        name: {
            "points": one.points.tolist(),
            "time": one.time.tolist(),
            "by_sample": _both(one, 0, added=bool(added)),
            "by_frame": _both(one, 1, added=bool(added)),
        }
        for runs, added in ((fitted, found.additions), (others, found.rounds))
        for name, one in runs.items()
    }


def _apart(run: RunFit) -> np.ndarray:
    return run.simulated - run.measured


def _both(one: Differences, axis: int, *, added: bool) -> dict[str, list[float] | None]:
    return {
        "before": _over(one.before, axis).tolist(),
        "after": _over(one.after, axis).tolist() if added else None,
    }


def _over(apart: np.ndarray, axis: int) -> np.ndarray:
    """Root mean square over frames or samples [K]; NaN where nothing was read."""
    square = apart**2
    count = np.isfinite(square).sum(axis)
    total = np.where(np.isfinite(square), square, 0.0).sum(axis)
    return np.where(count > 0, np.sqrt(total / np.maximum(count, 1)), np.nan)


def _calibration(found: Calibration) -> dict[str, Any]:
    chance = np.arange(1, 100) / 100
    return {
        "draws": len(found.largest),
        "false_alarms": {
            "by_score": found.by_score, "by_shapes": found.by_shapes, "either": found.either,
        },
        "largest_score": {
            "chance": chance.tolist(), "value": np.quantile(found.largest, chance).tolist(),
        },
    }  # fmt: skip


def _round(one: Round, explains: bool) -> dict[str, Any]:
    name = one.effect.card.name
    return {
        "named": [name] if explains and len(one.together) == 1 else [],
        "set": one.together,
        "best": name,
        **_effect(one.effect),
        "p_value": one.p_value,
        "gap_closed": one.closed,
        "rms_before": dict(one.rms_before),
        "rms_after": dict(one.rms_after),
        "alternatives": {other: _alternative(fit) for other, fit in one.alternatives.items()},
        "threshold": one.threshold,
        "candidates": [_candidacy(item) for item in one.candidates],
    }


def _alternative(one: Alternative) -> dict[str, Any]:
    parameters = {
        name: {"value": value, "interval95": list(ends)}
        for name, (value, ends) in one.parameters.items()
    }
    held_out = dict(one.held_out)
    return {
        **_effect(one.effect), "rms": dict(one.rms), "parameters": parameters, "held_out": held_out
    }  # fmt: skip


def _effect(effect: Effect) -> dict[str, Any]:
    return {
        "strength": effect.strength,
        "sd": effect.sd,
        "interval95": list(effect.interval95),
        "strengths": list(effect.strengths) or None,
        "unit": effect.card.unit,
        "location": _location(effect),
        "transition": None
        if effect.transition is None
        else dict(zip(("temperature", "width"), effect.transition, strict=True)),
        "part": effect.part,
        "side": effect.side,
        "depth": effect.depth,
        "conductance": effect.conductance,
        "conductance_interval95": effect.conductance95 and list(effect.conductance95),
    }


def _location(effect: Effect) -> dict[str, Any] | None:
    """Where an effect is [m], with all that its place is built from."""
    if effect.centre is None:
        return None
    found: dict[str, Any] = {"centre": effect.centre.tolist(), "size": effect.size}
    if effect.outline is not None:
        found["middle"] = effect.outline.centre[0].tolist()
        found["half_widths"] = effect.outline.size[0].tolist()
        found["squareness"] = float(effect.outline.squareness[0])
        found["sharpness"] = float(effect.outline.sharpness[0])
    return found


def _candidacy(one: Candidacy) -> dict[str, Any]:
    return {
        "name": one.card.name,
        "score": one.score,
        "strength": one.strength,
        "sd": one.sd,
        "unit": one.card.unit,
        "least": one.card.low if math.isfinite(one.card.low) else None,
        "most": one.card.high if math.isfinite(one.card.high) else None,
        "visible": one.visible,
        "left": one.left,
        "correlation": one.correlation,
        "bic": one.bic,
        "means": one.card.means,
        "excited_by": one.card.excited_by,
        "hides_behind": one.card.hides_behind,
        "split_by": one.card.split_by,
    }


def verdict_sentences(found: Verdict) -> list[str]:
    """The verdict in words, temperatures [K]."""
    told = {
        "named": [_named(one.effect) for one in found.rounds],
        "inseparable": [_inseparable(one) for one in found.rounds],
        "none_of_mine": [_none(found)],
        "no_gap": ["No gap: simulation and readings differ by no more than noise and numerics."],
    }[found.verdict]
    if found.effects():
        told += [
            _held(one, last=one is found.rounds[-1])
            for one in found.rounds
            if len(one.together) > 1
        ]
    told += [
        _proof(name, one, found.verdict) if found.rounds else _as_stated(name, one)
        for name, one in found.held_out.items()
    ]
    return [*told, *found.remarks]


def _as_stated(name: str, one: HeldOut) -> str:
    """What a run that was not fitted says of a model to which nothing was added."""
    return (
        f"On {name}, which was not fitted, the difference is {one.rms_before:.3g} K, "
        f"at a noise of {one.noise:.3g} K."
    )


def _proof(name: str, one: HeldOut, verdict: str) -> str:
    """What a run that was not fitted says."""
    closest = " with what comes closest" if verdict == "none_of_mine" else ""
    goes = "rises" if one.rms_after > one.rms_before else "falls"
    wrong = one.rms_after**2 - one.rms_before**2 > one.noise**2
    more = " What explains the fitted runs does not hold there." if wrong else ""
    return (
        f"On {name}, which was not fitted, the difference {goes} from {one.rms_before:.3g} "
        f"to {one.rms_after:.3g} K{closest}, at a noise of {one.noise:.3g} K.{more}"
    )


def _named(effect: Effect) -> str:
    known = effect.card.alike and effect.strength > 0
    alike = f" It may as well be {effect.card.alike}." if known else ""
    means = f" Its strength: {effect.card.means}." if effect.card.means else ""
    return f"Missing effect: {_told(effect)}.{means}{alike}"


def _told(effect: Effect) -> str:
    """An effect with its strength and its place."""
    low, high = effect.interval95
    whole = ""
    if effect.conductance is not None and effect.conductance95 is not None:
        ends = "[{:.3g}, {:.3g}]".format(*effect.conductance95)
        whole = f", {effect.conductance:.3g} W/K {ends} in all"
    part = "" if effect.part is None else f" {effect.part}"
    if effect.strengths:
        whole += f", in turn {', '.join(f'{one:.3g}' for one in effect.strengths)}"
    return (
        f"{_spoken(effect.card.name)}{part}, {effect.strength:.4g}{_unit(effect.card.unit)} "
        f"[{low:.4g}, {high:.4g}]{_place(effect)}{whole}"
    )


def _place(effect: Effect) -> str:
    """Where an effect is, and how far it reaches; nothing where it has no place."""
    if effect.transition is not None:
        return ", at {:.4g} K, over {:.2g} K".format(*effect.transition)
    place = ""
    if effect.centre is not None:
        place = f", at ({_millimetres(effect.centre)}) mm"
        if effect.outline is not None:
            place += f" within half-widths of ({_millimetres(effect.outline.size[0])}) mm"
            about = _millimetres(effect.outline.centre[0])
            place += "" if about == _millimetres(effect.centre) else f" about ({about}) mm"
        elif effect.size is not None:
            place += f" fading over {1e3 * effect.size:.2g} mm"
    if effect.side is not None:
        place = f", at the side {effect.side}"
    # A support that ends with a flat side reaches no deeper.
    flat = effect.side is not None and (effect.depth or 0.0) < _FLAT * (effect.size or 0.0)
    if effect.depth is not None and not flat:
        place += f", to a depth of {1e3 * effect.depth:.2g} mm"
    return place


def _millimetres(ways: Iterable[Any]) -> str:
    # No zero with a sign.
    return ", ".join(f"{round(1e3 * float(one), 1) + 0.0:.1f}" for one in ways)


def _inseparable(one: Round) -> str:
    if len(one.together) == 1:
        return _named(one.effect)
    names = " from ".join(_spoken(name) for name in one.together)
    return f"Cannot tell {names}. What would: {one.effect.card.split_by}."


def _held(one: Round, *, last: bool) -> str:
    """The best of a set, and what would stand in its place; `last`: of the rounds."""
    # What was fitted in an earlier round lacks the effects of those that came later.
    others = " or ".join(
        _told(other.effect) + (_with(other.parameters) if last else "")
        for other in one.alternatives.values()
    )
    instead = f" In its place would stand {others}." if others else ""
    return f"The model holds {_told(one.effect)}.{instead}"


def _with(parameters: Mapping[str, tuple[float, tuple[float, float]]]) -> str:
    """The unknowns beside an effect, each in its unit."""
    told = ", ".join(
        f"{_spoken(name)} {value:.4g}{_unit(QUANTITIES[name].unit)} [{low:.4g}, {high:.4g}]"
        for name, (value, (low, high)) in parameters.items()
    )
    return f" (with {told})" if told else ""


def _none(found: Verdict) -> str:
    words = "A gap exists, and none of the candidates explains it"
    fitted = ", ".join(_spoken(name) for name in found.parameters)
    beside = f" What was fitted, {fitted}, bends to it, and is no measurement." if fitted else ""
    if not found.rounds:
        return f"{words}.{beside}"
    closest = found.rounds[0]
    return (
        f"{words}; the closest is {_spoken(closest.effect.card.name)}{_place(closest.effect)}, "
        f"which closes {100 * closest.closed:.0f} % of it.{beside}"
    )


def _unit(name: str) -> str:
    """A unit behind a number."""
    return "" if name == "1" else f" {name}"


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def discovery_table(record: Mapping[str, Any]) -> str:
    """The scores of all kinds, for the terminal."""
    rows = []
    for one in record["candidates"]:
        strength = passed_limit(one) or one["strength"]
        rows.append([one["name"], one["score"], strength, one["unit"], one["visible"]])
    return table(rows, ["candidate", "score", "strength alone", "unit", "visible"])


def write_discovery(out: Path | str, found: Verdict, record: Mapping[str, Any]) -> None:
    """Leaves `verdict.json` in a folder, `verdict.html`, which is rendered from it, and the model.

    The folder is made where it is missing. The model is `estimate.npz`, the fields [SI] with the
    effects that were found, for `thermo predict`.
    """
    out = Path(out)
    save_estimate(out / "estimate.npz", found.extended, effects_as_arrays(found.additions))
    path = out / "verdict.json"
    write_json(path, record)
    title = f"{record['object']}: what is missing"
    write_text(out / "verdict.html", discovery_page(json.loads(path.read_text("utf-8")), title))

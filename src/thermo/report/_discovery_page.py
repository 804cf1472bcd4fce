"""One page in HTML, without a network, on what is missing; rendered from its JSON alone."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from plotly.graph_objects import Figure
from plotly.offline import get_plotlyjs

from thermo.fields import QUANTITIES

from ._discovery_plots import (
    alias_matrix,
    chance_curve,
    held_out_bars,
    residual_curves,
    residual_maps,
    score_bars,
    spoken,
)
from ._html_page import html_page
from ._identifiability_page import _STYLE, _plots, _section, _table
from ._passed_limit import passed_limit

_MORE = """
.said { font-size: 1.15rem; line-height: 1.35; margin: 0.5rem 0; }
.lead { font-size: 1.7rem; font-weight: 600; }
.named { color: #1b6e3c; }
.inseparable { color: #8a5a00; }
.none_of_mine { color: #a3242b; }
.below { color: #666; } .note { color: #555; font-size: 0.9rem; }
td { vertical-align: top; } tr { break-inside: avoid; }
#rounds td:nth-child(6), #candidates td:nth-child(2) { white-space: nowrap; }
"""

Record = Mapping[str, Any]


def discovery_page(record: Mapping[str, Any], title: str) -> str:
    """The page of a search [SI]; `record` is what `verdict.json` holds."""
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        _verdict(record),
        _section("Rounds", "rounds", _rounds(record)),
        _section("Where simulation and readings differ", "gap", _gap(record)),
        _section("Scores of the candidates", "scores", _scores(record)),
        _section("All candidates", "candidates", _candidates(record)),
        _section("Which hide behind which", "alias", _alias(record)),
        _section("Runs that were not fitted", "held_out", _held_out(record)),
        _section("Parameters before and after", "parameters", _parameters(record)),
        _section("How often an alarm would be false", "calibration", _calibration(record)),
        _section("What could have been missed", "missed", _missed(record)),
        _section("Noise and numerics", "noise", _noise(record)),
        _section("Made with", "versions", _made_with(record)),
    ]
    return html_page(title, _STYLE + _MORE, "\n".join(parts), script=get_plotlyjs())


def _verdict(record: Record) -> str:
    word = record["verdict"]
    # A sentence for each effect comes first; held-out runs and remarks come after.
    first = len(record["rounds"]) if word in ("named", "inseparable") else 1
    lead = f"lead {html.escape(word)}"
    said = [
        f'<p class="said {lead if number < first else "more"}">{html.escape(line)}</p>'
        for number, line in enumerate(record["sentences"])
    ]
    name = f'<p class="note">Verdict: <code>{html.escape(word)}</code></p>'
    return f'<section id="verdict">{name}{"".join(said)}</section>'


def _rounds(record: Record) -> str:
    chance = record["p_value"]
    before, after = _chance(chance["without"]), _chance(chance["with"])
    told = "Chance that noise and numerics alone leave so large a misfit in smooth shapes: "
    if not record["rounds"]:
        return _note("No candidate was put to work.") + _note(f"{told}{before}.")
    header = ["round", "effect", "strength", "95 % interval", "place [mm]", "p-value",
              "gap closed", "rms before and after [K]"]  # fmt: skip
    rows, kinds = [], []
    for number, one in enumerate(record["rounds"], 1):
        chances = [_chance(one["p_value"]), _share(one["gap_closed"])]
        falls = _falls(one["rms_before"], one["rms_after"])
        rows.append([str(number), _what(one, record["verdict"]), *_effect(one), *chances, falls])
        kinds.append("round")
        for name, other in one["alternatives"].items():
            falls = _falls(one["rms_before"], other["rms"])
            rows.append(
                [str(number), f"{spoken(name)}, in its place", *_effect(other), "", "", falls]
            )
            kinds.append("alternative")
    body = _table(header, rows, kinds)
    return body + _note(
        f"{_CHANCES} {told}{before} before the first round, {after} after the last."
    )


_NEARLY = 0.999
"""A share that would be written as all [1]."""

_NONE = 1e-5
"""A share that is no more than what rounding leaves [1]."""

_CHANCES = (
    "A p-value is the chance that noise makes any candidate, wherever it was looked for, explain "
    "as much. The other chance asks for no effect: it counts what is left in smooth shapes alone, "
    "and may be large where an effect is sure that shows in few readings."
)


def _what(one: Record, verdict: str) -> str:
    """What a round found, in words."""
    if len(one["set"]) > 1:
        names = " or ".join(spoken(name) for name in one["set"])
        words = f"{names}: cannot be told apart. The numbers are of {spoken(one['best'])}"
    else:
        words = spoken(one["best"])
    return f"{words} (the closest, not named)" if verdict == "none_of_mine" else words


def _effect(one: Record) -> list[str]:
    """How strong an effect is, and where."""
    interval = " to ".join(_number(end) for end in one["interval95"])
    amounts = (_amount(told, one["unit"]) for told in (one["strength"], interval))
    return [*amounts, _place(one) + _whole(one)]


def _place(one: Record) -> str:
    """Where an effect is and how far it reaches [mm], from metres."""
    found, depth = one["location"], one["depth"]
    deep = "" if depth is None else f", {_number(1e3 * depth, '.2g')} deep"
    if one["side"] is not None:
        return f"side {one['side']}{deep}"
    if found is None:
        return f"{one['part'] or 'no place'}{deep}"
    centre = ", ".join(f"{1e3 * one:.1f}" for one in found["centre"])
    return f"({centre}), size {1e3 * found['size']:.1f}"


def _whole(one: Record) -> str:
    """What an effect takes over all of its place [W/K]."""
    if one["conductance"] is None:
        return ""
    ends = " to ".join(_number(end, ".3g") for end in one["conductance_interval95"])
    return f"; {_number(one['conductance'], '.3g')} W/K ({ends}) in all"


def _falls(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """Root mean squares by run [K]."""
    ends = ((name, before[name], after[name]) for name in before)
    return "; ".join(f"{n}: {_number(b, '.3g')} to {_number(a, '.3g')}" for n, b, a in ends)


def _gap(record: Record) -> str:
    header = ["run", "part", "readings or shapes", "squares before", "squares after"]
    rows = [
        [name, part, str(one["expected"]), _number(one["squares"], ".4g"),
         _number(found["after"][part]["squares"], ".4g")]
        for name, found in record["gap"].items()
        for part, one in found["before"].items()
    ]  # fmt: skip
    words = (
        "Squares of simulation less readings, in units of noise and of what is allowed for: those "
        "smooth over the body and steady, smooth and changing in time, and the rest. They add up; "
        "noise alone leaves about as many as there are readings in the rest, and fewer than there "
        "are shapes, as far as what is allowed for is not there."
    )
    figures = []
    for name in record["gap"]:
        figures += _drawn(record, name, record["noise"][name])
    told = _table(header, rows, ["part"] * len(rows)) + _note(words)
    return _plots(figures, "gap") + told + _over_time(record)


def _drawn(record: Record, run: str, noise: float | None) -> list[Figure]:
    """What is left of a run, by sample and over time, beside its noise [K]."""
    found = record["residuals"][run]
    return [residual_maps(run, found), residual_curves(run, found, noise)]


def _over_time(record: Record) -> str:
    header = ["run", "what is left follows", "score before (lag)", "chance", "score after (lag)",
              "chance"]  # fmt: skip
    rows = []
    for name, found in record["over_time"].items():
        ends = found["before"], found["after"]
        slow = [part for one in ends for part in ("", _chance(one["slow_p_value"]))]
        rows.append([name, "slow changes rather than fast ones", *slow])
        for known in found["before"]["follows"]:
            each = [one["follows"][known] for one in ends]
            told = [
                part
                for one in each
                for part in (
                    f"{_number(one['score'], '.1f')} ({_number(one['lag_s'], '.3g')} s)",
                    _chance(one["p_value"]),
                )
            ]
            rows.append([name, f"the {known}", *told])
    words = (
        "The mean over all samples, frame by frame, against what is known of the run, at the lag "
        "where it follows that most, no time constant of an effect; the chance is that noise does "
        "so at any lag."
    )
    return _table(header, rows, ["trace"] * len(rows)) + _note(words)


def _first_round(record: Record) -> tuple[Sequence[Record], float]:
    """The candidates of round 1 and the threshold of their scores [1]."""
    rounds = record["rounds"]
    # Only a round knows what was left by the candidates that it refitted.
    where = rounds[0] if rounds else record
    return where["candidates"], where["threshold"]


def _scores(record: Record) -> str:
    found, threshold = _first_round(record)
    seen = [one for one in found if one["score"] is not None and np.isfinite(one["score"])]
    if not seen:
        return _note("No candidate could be seen in these runs.")
    words = (
        "The bars show the size of each score in round 1, in standard deviations. The dashed line "
        f"is the threshold, {threshold:.3g}. Grey bars do not pass it. A score below zero does not "
        "count where a strength below zero cannot be."
    )
    return _plots([score_bars(seen, threshold)], "scores") + _note(words)


def _candidates(record: Record) -> str:
    found, threshold = _first_round(record)
    if not found:
        return _note("No candidate could be seen in these runs.")
    header = ["candidate", "score", "strength alone", "visible", "left when refitted",
              "hides behind", "would be split by"]  # fmt: skip
    rows = [
        [
            spoken(one["name"]),
            _number(one["score"], "+.3g"),
            _alone(one),
            _share(one["visible"]),
            "not refitted" if one["left"] is None else _share(one["left"]),
            one["hides_behind"],
            one["split_by"],
        ]
        for one in found
    ]
    kinds = [_kind(one, record, threshold) for one in found]
    return _table(header, rows, kinds) + _note(_CANDIDATES)


def _alias(record: Record) -> str:
    found = record["alias"]
    if len(found) < 2:
        return _note("There are no two candidates to compare.")
    words = (
        "Cosines between what two candidates do to the readings of the fitted runs, where the "
        "unknowns give way, at the best place of each. Those near one cannot be told apart while "
        "they are weak; their places and strengths may tell them apart when they are strong."
    )
    return _plots([alias_matrix(found)], "alias") + _note(words)


def _alone(one: Record) -> str:
    """Strength where nothing else is missing, in its unit."""
    known = f"{_number(one['strength'], '.3g')} ± {_number(one['sd'], '.2g')}"
    return _amount(passed_limit(one) or known, one["unit"])


def _kind(one: Record, record: Record, threshold: float) -> str:
    """The class of a candidate's row."""
    if record["effects"]:
        for found in record["rounds"]:
            if one["name"] in found["set"]:
                return "named" if len(found["set"]) == 1 else "inseparable"
    return "above" if abs(one["score"] or 0.0) > threshold else "below"


_CANDIDATES = (
    "All numbers are of round 1. Strength alone is what is foretold where nothing else is missing, "
    "with its standard deviation. Visible is the share of the signature that the unknowns do not "
    "swallow. Left when refitted is the share of the gap that a candidate leaves, where the gap is "
    "what the one that closes most does: that one leaves nothing."
)


def _held_out(record: Record) -> str:
    found = record["held_out"]
    if not found:
        return _note("No run was held out, so nothing is proved on readings that were not fitted.")
    header = ["run", "rms before [K]", "rms after [K]", "noise [K]", "gap closed"]
    rows, kinds = [], []
    for name, one in found.items():
        before, after, noise = (
            _number(one[key], ".3g") for key in ("rms_before", "rms_after", "noise")
        )
        rows.append([name, before, after, noise, _closed(one)])
        kinds.append("held")
        for other, left in _left_with(record, name).items():
            rows.append([f"{name}, with {spoken(other)}", before, _number(left, ".3g"), noise, ""])
            kinds.append("alternative")
    figures = [held_out_bars(found)]
    for name, one in found.items():
        figures += _drawn(record, name, one["noise"])
    drawn = _plots(figures, "held-out")
    return drawn + _table(header, rows, kinds)


def _left_with(record: Record, run: str) -> dict[str, float]:
    """What the last effect's alternatives leave on a run that was not fitted [K], by name."""
    last = record["rounds"][-1]["alternatives"] if record["effects"] else {}
    return {name: one["held_out"][run] for name, one in last.items() if run in one["held_out"]}


def _closed(one: Record) -> str:
    if one["gap_closed"] is None:
        return "nothing to close"
    ends = one["gap_closed_interval95"]
    among = "" if ends is None else f" [{_share(ends[0])}, {_share(ends[1])}]"
    return _share(one["gap_closed"]) + among


def _parameters(record: Record) -> str:
    found = record["parameters"]
    if not found:
        return _note("No parameter was fitted.")
    rows = [
        [spoken(name), *_values(name, one["before"], one["after"], one["interval95"])]
        for name, one in found.items()
    ]
    for other, fit in record["rounds"][-1]["alternatives"].items() if record["effects"] else ():
        rows += [
            [
                f"{spoken(name)}, with {spoken(other)}",
                *_values(name, found[name]["before"], one["value"], one["interval95"]),
            ]
            for name, one in fit["parameters"].items()
        ]
    heads = ["unknown", "before", "after", "95 %", "change"]
    made = _table(heads, rows, ["parameter"] * len(rows))
    placed = record["effects"] and any(one["location"] for one in record["rounds"])
    return made + (_note("Intervals leave out what the shape of a place may be.") if placed else "")


def _values(
    name: str, before: float | None, after: float | None, interval: list[float] | None
) -> list[str]:
    """An unknown without and with what was found [SI]."""
    both = (_amount(_number(one), _unit(name)) for one in (before, after))
    return [*both, _ends(interval), _change(before, after)]


def _ends(interval: list[float] | None) -> str:
    return "no measurement" if interval is None else " to ".join(_number(one) for one in interval)


def _unit(name: str) -> str:
    return QUANTITIES[name].unit if name in QUANTITIES else "1"


def _change(before: float | None, after: float | None) -> str:
    if not before or after is None:
        return "not known"
    return f"{100 * (after / before - 1):+.2g} %"


def _calibration(record: Record) -> str:
    found, told = record["calibration"], record["candidates"]
    shares = {name: _share(share) for name, share in found["false_alarms"].items()}
    words = (
        f"Of {found['draws']} residuals drawn as noise and what is allowed for make them, each "
        f"through the fit, linearised, {shares['either']} raise an alarm: {shares['by_score']} by "
        f"a score and {shares['by_shapes']} by smooth shapes. 4 and 1 % are aimed at."
    )
    largest = max((abs(one["score"]) for one in told if one["score"] is not None), default=None)
    return _plots(
        [chance_curve(found["largest_score"], record["threshold"], largest)], "chance"
    ) + _note(words)


def _missed(record: Record) -> str:
    found = record["could_have_missed"]
    if not found:
        return _note("Nothing that was looked for.")
    shares = list(next(iter(found.values()))["found_in"])
    rows = [
        [spoken(name), *(_strength(one["found_in"][share], one["unit"]) for share in shares)]
        for name, one in found.items()
    ]
    kinds = ["below" if one["strength"] is None else "seen" for one in found.values()]
    header = ["candidate", *(f"found in {100 * float(share):g} % of cases" for share in shares)]
    words = "So strong it has to be, wherever it is. Weaker effects may be there unseen."
    return _table(header, rows, kinds) + _note(words)


def _strength(least: float | None, unit: str) -> str:
    return "none that can be" if least is None else _amount(_number(least, ".3g"), unit)


def _noise(record: Record) -> str:
    noise, numerics = record["noise"], record["numerics"]["cells_and_steps_K"]
    rows = [
        [name, *(_number(found.get(name), ".2g") for found in (noise, numerics))]
        for name in {**noise, **numerics}
    ]
    words = "What cells and steps make wrong is taken off, and a third of it is allowed for."
    header = ["run", "noise of a reading [K]", "wrong by cells and steps [K]"]
    return _table(header, rows, ["run"] * len(rows)) + _note(words)


def _made_with(record: Record) -> str:
    made = ", ".join(f"{name} {value}" for name, value in record["versions"].items())
    took = f" in {record['seconds']:.0f} s" if record.get("seconds") is not None else ""
    return f"<p>{html.escape(made)}{took}</p>"


def _note(words: str) -> str:
    return f'<p class="note">{html.escape(words)}</p>'


def _number(value: float | None, form: str = ".4g") -> str:
    """A number in words; JSON holds null for one that is not finite."""
    return "not known" if value is None or not np.isfinite(value) else format(value, form)


def _amount(value: float | str | None, unit: str) -> str:
    words = value if isinstance(value, str) else _number(value)
    return words if unit == "1" or words == "not known" else f"{words} {unit}"


def _share(value: float | None) -> str:
    # A zero is added so that what is rounded to zero has no sign.
    if value is None:
        return "not known"
    if _NEARLY < value < 1.0:
        return f"above {100 * _NEARLY:.1f} %"
    if _NONE < value < 1 - _NEARLY:
        return f"{100 * value:.1g} %"
    return f"{round(100 * value, 1) + 0.0:.1f} %"


def _chance(value: float | None) -> str:
    # Where the chance is too small for a number of the machine, it is exactly zero.
    return "below 1e-300" if value is not None and value < 1e-300 else _number(value, ".2g")

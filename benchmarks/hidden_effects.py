"""Hidden effects of our own making: what `thermo.discover` says of each, and how often it is right.

    python benchmarks/hidden_effects.py [--out FOLDER] [--clean 200] [--draws 10] [--share 0/2]
    python benchmarks/hidden_effects.py --others --clean 12 --draws 2 [--out FOLDER]
    python benchmarks/hidden_effects.py --alike --draws 4 [--out FOLDER]
    python benchmarks/hidden_effects.py --forms --draws 5 [--out FOLDER]
    python benchmarks/hidden_effects.py --surfaces GEOMETRY --clean 8 --draws 2 [--out FOLDER]

Five bodies, three kinds of noise; recordings by scikit-fem in quadratic functions on structured
tetrahedra and by TR-BDF2, none of which is the project's own solver, corrected by what shorter
cells and steps read where nothing is hidden (some minutes once for each pair of body and material).
Cases: nothing hidden, seventeen effects of the library, seven that it lacks, six pairs.

A case whose result lies in FOLDER is not made again, so that the suite can be interrupted.
`--share 0/2` and `--share 1/2` make its halves side by side, body by body, since the cases of one
body share compiled programs. `--table` adds what FOLDER holds to the tables in benchmarks/results.
`--others` takes two other bodies of two other materials: nothing of the search was settled on them.
`--alike` hides two effects at once of which neither is more than 1.2 times as visible as the other.
`--forms` hides effects of the library at places that have not the form that it looks for.
`--surfaces` takes bodies from files: bracket, pinion, spot and rocker_arm in the folder GEOMETRY.
`--check` prints how exact the recordings are: what the last cut of cells and steps changed.
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from hidden._bodies import FILES
from hidden._scenes import (
    OTHERS,
    SHAPES,
    SURFACES,
    Case,
    Made,
    NothingDrawnError,
    alike,
    cases,
    exactness,
    forms,
    make,
    the_body,
)

from thermo.discover import Verdict, discover
from thermo.inverse import Meshing
from thermo.report import discovery_record

RESULTS = Path(__file__).parent / "results"
NODES = 3000


def main() -> None:
    """Run what is missing, or score what there is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("outputs/hidden"))
    parser.add_argument("--clean", type=int, default=200)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--share", default="0/1")
    parser.add_argument("--only", default="", help="words in the names of the cases to run")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--others", action="store_true")
    parser.add_argument("--alike", action="store_true")
    parser.add_argument("--forms", action="store_true")
    parser.add_argument("--surfaces", type=Path)
    asked = parser.parse_args()
    bodies, table = (OTHERS, "_others") if asked.others else (SHAPES, "")
    if asked.surfaces:
        bodies, table = SURFACES, "_surfaces"
        kept = asked.out / "meshes"
        FILES.update((one, (surface_of(asked.surfaces, one), kept)) for one in bodies)
    if asked.check:
        for what, apart in exactness(bodies):
            print(f"{what}: {1e3 * apart:.2g} mK", flush=True)
        return
    suite = cases(asked.clean, asked.draws, bodies)
    if asked.alike:
        suite, table = alike(asked.draws, bodies), f"{table}_alike"
    if asked.forms:
        suite, table = forms(asked.draws, bodies), f"{table}_forms"
    if asked.table:
        rows = [one for case in suite if (one := result(asked.out, case))]
        write_tables(rows, f"hidden_effects{table}")
        return
    part, parts = map(int, asked.share.split("/"))
    for number, case in enumerate(suite):
        mine = number * parts // len(suite) == part and asked.only in case.name()
        if not mine or result(asked.out, case):
            continue
        try:
            run(case, asked.out)
        except NothingDrawnError as fault:
            print(f"{fault}: left out", flush=True)


def surface_of(folder: Path, name: str) -> Path:
    """The file of a body's surface."""
    found = sorted(
        one for one in folder.glob(f"{name}.*") if one.suffix in (".ply", ".off", ".obj")
    )
    if not found:
        raise SystemExit(f"{folder} holds no {name}.ply, .off or .obj: give the folder of geometry")
    return found[0]


def result(out: Path, case: Case) -> dict[str, Any] | None:
    """What was found before, if it was."""
    path = out / "found" / f"{case.name()}.json"
    return json.loads(path.read_text("utf-8")) if path.exists() else None


def run(case: Case, out: Path) -> None:
    """Make a case, ask for the verdict, keep both."""
    folder = out / "scenes" / case.name()
    begun = time.monotonic()
    told = folder / "truth.json"
    if not told.exists():
        truth = truth_of(case, make(case, folder, out / "usual"))
        told.write_text(json.dumps(truth), "utf-8")
    truth = json.loads(told.read_text("utf-8"))
    made = time.monotonic()
    verdict = discover(folder, meshing=Meshing(max_nodes=NODES))
    row = truth | answer(verdict) | {
        "case": case.name(), "seconds": time.monotonic() - made, "making": made - begun,
    }  # fmt: skip
    path = out / "found" / f"{case.name()}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".tmp").write_text(json.dumps(row), "utf-8")
    path.with_suffix(".tmp").replace(path)
    record = discovery_record(verdict)
    path.with_suffix(".verdict").write_text(json.dumps(record), "utf-8")
    words = f"{row['verdict']} {row['sets']} {right(row)}"
    print(f"{case.name()}: {words}, {row['seconds']:.0f} s", flush=True)


def truth_of(case: Case, made: Made) -> dict[str, Any]:
    """What is hidden, in words."""
    return {
        "group": case.group, "shape": case.shape, "noise": case.noise, "material": case.material,
        "hidden": [one.kind for one in made.hidden],
        "true_strength": [one.strength for one in made.hidden],
        "where": [one.where for one in made.hidden], "visible": made.visible,
        "extent": float(np.ptp(the_body(case.shape).points, axis=0).max()),
    }  # fmt: skip


def answer(verdict: Verdict) -> dict[str, Any]:
    """What a verdict says, in the words of the table."""
    rounds = verdict.rounds if verdict.effects() else []
    (proof,) = verdict.held_out.values()
    return {
        "verdict": verdict.verdict,
        "closest": [one.effect.card.name for one in verdict.rounds],
        "sets": [one.together for one in rounds],
        "strength": [one.effect.strength for one in rounds],
        "interval": [one.effect.interval95 for one in rounds],
        "centre": [
            None if one.effect.centre is None else list(one.effect.centre) for one in rounds
        ],
        "held_out": [proof.rms_before, proof.rms_after, proof.noise],
        "largest": max(abs(one.score) for one in verdict.candidates),
        "by_correlation": by_correlation(verdict),
        "by_bic": by_bic(verdict),
        "threshold": verdict.threshold, "omnibus": list(verdict.omnibus),
    }  # fmt: skip


def by_correlation(verdict: Verdict) -> str | None:
    """The candidate whose signature is most like what is left, if any could be seen."""
    found = max(verdict.candidates, key=lambda one: one.correlation, default=None)
    return None if found is None else found.card.name


def by_bic(verdict: Verdict) -> str:
    """The candidate that Schwarz's criterion would name among the refits, or none."""
    found = verdict.rounds[0].candidates if verdict.rounds else []
    better = [one for one in found if one.bic is not None and one.bic < 0]
    return min(better, key=lambda one: one.bic or 0.0).card.name if better else ""


def alone(name: str | None, row: dict[str, Any]) -> str:
    """One word for a rule that names a candidate or an empty name; none where nothing is known."""
    if name is None:
        return ""
    if not name:
        return "right" if row["group"] == "clean" else "missed"
    return "right" if name in row["hidden"] else "wrong"


def right(row: dict[str, Any]) -> str:
    """One word for an answer: right, set (right among others), missed, refused or wrong."""
    named = [set(one) for one in row["sets"]]
    if row["verdict"] in ("no_gap", "none_of_mine"):
        wanted = {"clean": "no_gap", "outside": "none_of_mine"}.get(row["group"])
        if row["verdict"] == wanted:
            return "right"
        return "missed" if row["verdict"] == "no_gap" else "refused"
    if row["group"] in ("clean", "outside"):
        return "wrong" if any(len(one) == 1 for one in named) else "set of wrong ones"
    found = [any(kind in one for one in named) for kind in row["hidden"]]
    strange = [one for one in named if not one & set(row["hidden"])]
    if all(found) and not strange:
        return "right" if all(len(one) == 1 for one in named) else "set"
    if any(len(one) == 1 for one in strange):
        return "wrong"
    return "partly" if any(found) else "set of wrong ones"


def places_off(row: dict[str, Any]) -> list[float]:
    """How far the places that were found are from the hidden ones, over the object's size."""
    found = []
    for kind, where in zip(row["hidden"], row["where"], strict=True):
        centres = [
            centre for one, centre in zip(row["sets"], row["centre"], strict=False) if kind in one
        ]
        if where and centres and centres[0]:
            found.append(float(np.linalg.norm(np.subtract(centres[0], where))) / row["extent"])
    return found


HEADER = [
    "case", "material", "visible", "true strength", "verdict", "sets", "strength", "low",
    "high", "answer", "by correlation", "by BIC", "held out before", "held out after", "noise",
    "seconds", "place off by",
]  # fmt: skip


RULES = ("answer", "by correlation", "by BIC")
"""Ours, and what is compared with it: each names one candidate, BIC among the refits or none."""

PLAIN = ("right", "wrong")


def write_tables(rows: list[dict[str, Any]], name: str) -> None:
    """One line a case, and one a stratum; lines of cases that were not run now stay."""
    lines, path = {}, RESULTS / f"{name}.csv"
    if path.exists():
        with path.open(newline="", encoding="utf-8") as file:
            lines = {line[0]: line for line in list(csv.reader(file))[1:]}
    for row in rows:
        first = row["interval"][0] if row["interval"] else (None, None)
        numbers = [row["strength"][0] if row["strength"] else None, *first, *row["held_out"]]
        short = [None if one is None else f"{one:.5g}" for one in numbers]
        lines[row["case"]] = [
            row["case"], row["material"], " ".join(f"{one:.0f}" for one in row["visible"]),
            " ".join(f"{one:.5g}" for one in row["true_strength"]), row["verdict"],
            "; ".join(" ".join(one) for one in row["sets"]), *short[:3], right(row),
            alone(row["by_correlation"], row), alone(row["by_bic"], row), *short[3:],
            f"{row['seconds']:.0f}", " ".join(f"{off:.3f}" for off in places_off(row)),
        ]  # fmt: skip
    _write(path.name, [HEADER, *(lines[case] for case in sorted(lines))])
    strata: dict[tuple[str, str], list[list[Any]]] = {}
    for case, line in lines.items():
        group, hidden, shape, _, noise, _ = case.split("-")
        for stratum in ("all", noise if hidden == "clean" else hidden, shape):
            strata.setdefault((group, stratum), []).append(line)
    words = ["right", "set", "partly", "refused", "missed", "set of wrong ones", "wrong"]
    table = []
    for key, found in sorted(strata.items()):
        ours, *others = ([line[HEADER.index(rule)] for line in found] for rule in RULES)
        shares = [sum(answer == word for answer in one) for one in others for word in PLAIN]
        table.append([*key, len(found), *(ours.count(word) for word in words), *shares])
    header = [f"{rule}: {word}" for rule in RULES[1:] for word in PLAIN]
    _write(f"{name}_rates.csv", [["group", "stratum", "cases", *words, *header], *table])
    print(in_words([dict(zip(HEADER, line, strict=True)) for line in lines.values()]))


def in_words(lines: list[dict[str, str]]) -> str:
    """How good strengths, places and held-out runs are where effects of the library were named."""
    named = [one for one in lines if one["answer"] in ("right", "set") and one["sets"]]
    single = [one for one in named if one["case"].startswith(("within", "form"))]
    strengths = [[float(one[key]) for key in ("true strength", "strength", "low", "high")]
                 for one in single]  # fmt: skip
    held = [low <= true <= high for true, _, low, high in strengths]
    near = [abs(found - true) <= 0.15 * abs(true) for true, found, _, _ in strengths]
    places = [float(off) for one in named for off in one["place off by"].split()]
    left = [float(one["held out after"]) / float(one["noise"]) for one in named]
    seconds = sum(float(one["seconds"]) for one in lines)
    return (
        f"one effect hidden, {len(single)} named alone or in a set: {sum(held)} strengths in their "
        f"interval of 95 %, {sum(map(max, held, near))} there or within 15 %\n"
        f"{len(places)} places known, {sum(off <= 0.1 for off in places)} within 10 % of the "
        f"object's size, the farthest {max(places, default=0.0):.1%} off\n"
        f"{len(left)} named, one effect or two: held-out runs met to 1.1 of their noise in "
        f"{sum(one <= 1.1 for one in left)}, to {max(left, default=0.0):.2f} in all\n"
        f"{seconds / 3600:.1f} hours of one core"
    )


def _write(name: str, rows: list[list[Any]]) -> None:
    with (RESULTS / name).open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    for row in rows:
        print(", ".join("" if one is None else str(one) for one in row))


if __name__ == "__main__":
    main()

"""What to say beside effects that were found, which their names alone do not tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from thermo.discover._verdict import HeldOut, Round
from thermo.mesh import Mesh, locate
from thermo.observe import Run

_FACING: Final = 0.1
"""The least light on a side that counts, as a share of what one right across takes [1]."""

_LEFT: Final = 2.0
"""Times its noise [1] from which what is left of a run that was not fitted is worth words."""

_OFF: Final = 0.02
"""Of the body's size, from which a sample's distance from its surface is worth words [1]."""

_CHANCE: Final = 0.01
"""Of noise leaving as much in smooth shapes, below which more than noise is left [1]."""

_ALIKE: Final = 1e-3
"""Share of a gap [1]: that a rival leaves no more of it is worth words. It is the square of a
thirtieth, by which a stated value may well be off, and what an effect does with it."""

_LEFT_OVER: Final = (
    "More than noise is left: what could have been missed is told for noise alone, and may be more."
)


def cautions(
    rounds: Sequence[Round], runs: Sequence[Run], proof: Mapping[str, HeldOut], chance: float
) -> list[str]:
    """Sentences about effects at work.

    Arguments:

    - `rounds`: what was found; `runs`: those that were fitted.
    - `proof`: what runs that were not fitted say; `chance` of noise leaving as much [1].
    """
    alike = [_alike(one) for one in rounds]
    sides = [_lit(one, runs) for one in rounds]
    signs = [_unsigned(one) for one in rounds]
    tests = [_hardly_tested(name, one) for name, one in proof.items()]
    left = [_LEFT_OVER] if chance < _CHANCE else []
    return [*filter(None, (*alike, *sides, *signs, *tests)), *left]


def samples_off(runs: Sequence[Run], mesh: Mesh) -> list[str]:
    """Sentences about runs whose samples lie off the surface of a mesh [m], though not too far."""
    size = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
    found = []
    for run in runs:
        distance = locate(mesh, run.recording.points).distance
        far = distance > _OFF * size
        if far.any():
            found.append(
                f"{far.sum()} of {len(far)} samples of {run.name} lie more than "
                f"{1e3 * _OFF * size:.2g} mm off the surface, the farthest "
                f"{1e3 * distance.max():.2g} mm: if points and surface do not share one frame, the "
                "others have slid along it, and what is left may come from that."
            )
    return found


def _alike(one: Round) -> str:
    """Rivals that readings exclude by little: not if what is stated is a little off, perhaps."""
    near = {
        item.card.name.replace("_", " "): item.left
        for item in one.candidates
        if item.left is not None and item.left < _ALIKE and item.card.name not in one.together
    }
    if not near:
        return ""
    best = one.effect.card.name.replace("_", " ")
    told = " and ".join(f"{name} leaves {100 * left:.1g} %" for name, left in near.items())
    return (
        f"{told} of what {best} closes, and is not in the set, as readings speak against it by "
        "more than noise. But a value that is stated, not fitted, and off by some per cent, an "
        "emissivity say, may make as small a difference. What would tell them apart whatever is "
        "stated: "
        f"{one.effect.card.split_by}."
    )


def _lit(one: Round, runs: Sequence[Run]) -> str:
    """A side that a lamp lights is no place for what lies against a body."""
    side = one.effect.side
    if side is None:
        return ""
    normal = np.zeros(3)
    normal["xyz".index(side[1])] = 1.0 if side[0] == "+" else -1.0
    lit = [
        run.name
        for run in runs
        if run.heater is not None and -float(run.heater.direction @ normal) > _FACING
    ]
    if not lit:
        return ""
    name = one.effect.card.name.replace("_", " ")
    return (
        f"Under the lamp of {', '.join(lit)} the side {side} is lit. If nothing lies against it, "
        f"{name} stands for what reads alike: another loss there, or power that is not taken up."
    )


def _unsigned(one: Round) -> str:
    low, high = one.effect.interval95
    if not low < 0 < high:
        return ""
    name = one.effect.card.name.replace("_", " ")
    return (
        f"The strength of {name} alone is not known, nor its sign: it depends on where it is. "
        "That something is missing is."
    )


def _hardly_tested(name: str, one: HeldOut) -> str:
    if one.interval95 is not None or one.rms_after <= _LEFT * one.noise:
        return ""
    return (
        f"{name} has too few samples to say what share is closed, and counts as proof where the "
        f"difference does not grow; {one.rms_after / one.noise:.2g} times its noise is left there."
    )

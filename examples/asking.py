"""What the examples that ask for a missing effect share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from thermo import Estimate
from thermo.discover import Candidate, Setting, Verdict, library
from thermo.discover.candidates import CameraDrift, CameraEmissivity
from thermo.report import discovery_record, write_discovery


def without(*kinds: type[Candidate]) -> Callable[[Setting], tuple[Candidate, ...]]:
    """What makes the library's candidates without some kinds, which are known to be absent."""
    return lambda setting: tuple(one for one in library(setting) if not isinstance(one, kinds))


CAMERA = (CameraEmissivity, CameraDrift)
"""What a camera may do wrong, and thermocouples do not."""


def tell(verdict: Verdict, name: str, out: Path) -> None:
    """Print what was found, round by round, and leave the page and a picture of that object."""
    for number, one in enumerate(verdict.rounds, 1):
        low, high = one.effect.interval95
        print(
            f"round {number}: {' or '.join(one.together)}, {one.effect.strength:.3g} "
            f"{one.effect.card.unit} [{low:.3g}, {high:.3g}]"
        )
        for run, before in one.rms_before.items():
            print(f"  {run}: rms {before:.3f} to {one.rms_after[run]:.3f} K")
    for parameter, (before, after) in verdict.parameters.items():
        print(f"{parameter}: {before:.4g} before, {after:.4g} after")
    record = discovery_record(verdict) | {"object": name}
    print(*record["sentences"], sep="\n")
    write_discovery(out, verdict, record)
    draw(verdict, f"{name}: {', '.join(verdict.effects()) or verdict.verdict}", out / "curves.png")
    print(f"page: {out / 'verdict.html'}\npicture: {out / 'curves.png'}")


def draw(verdict: Verdict, title: str, path: Path) -> None:
    """Readings, the model without and with what was found, and what is left, as PNG.

    A row a run, and below it what is left; where nothing was found there is one column. Of more
    than eight samples those are shown that lie evenly between the coldest and the hottest.
    """
    fits = {"as it is stated": verdict.stated}
    if verdict.additions:
        fits["with what was found"] = verdict.extended
    names = list(verdict.stated.runs)
    figure = Figure(figsize=(5.2 * len(fits), 3.6 * len(names)), layout="constrained")
    figure.suptitle(title, fontsize=11)
    axes = figure.subplots(
        2 * len(names), len(fits), sharex="row", sharey="row", squeeze=False,
        height_ratios=(2, 1) * len(names),
    )  # fmt: skip
    for column, (words, fit) in enumerate(fits.items()):
        for row, name in enumerate(names):
            above, below = axes[2 * row, column], axes[2 * row + 1, column]
            _curves(above, below, fit, name)
            above.set_title(f"{name}, {words}: {fit.runs[name].rmse:.3g} K (RMS)", fontsize=9)
        axes[-1, column].set_xlabel("time [s]")
    for row in range(len(names)):
        axes[2 * row, 0].set_ylabel("temperature [K]")
        axes[2 * row + 1, 0].set_ylabel("measured − simulated [K]", fontsize=8)
    figure.savefig(path, dpi=110)


def _curves(above: Axes, below: Axes, fit: Estimate, name: str) -> None:
    run = fit.runs[name]
    order = np.argsort(np.nanmax(run.measured, axis=0))
    shown = order[np.unique(np.linspace(0, len(order) - 1, min(8, len(order))).astype(int))]
    for place, sample in enumerate(shown):
        colour = colormaps["viridis"](place / max(len(shown), 2))
        above.plot(run.time, run.measured[:, sample], ".", ms=3, color=colour)
        above.plot(run.time, run.simulated[:, sample], "-", lw=1, color=colour)
        below.plot(run.time, run.measured[:, sample] - run.simulated[:, sample], lw=1, color=colour)
    below.axhline(0.0, color="0.6", lw=0.8)

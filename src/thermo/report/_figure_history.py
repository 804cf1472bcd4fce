"""The loss over the steps of an inversion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.ticker import MaxNLocator

from ._canvas import new_figure, round_ticks, save, tidy


def figure_history(
    path: Path,
    losses: Sequence[float] | Float[np.ndarray, " steps"],
    starts: Sequence[int] = (0,),
    title: str = "Loss history",
) -> None:
    """Draws the loss after each step, and the best so far, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `losses`: the loss [1] at the start and after each step; steps without a finite loss are
      gaps. The axis is logarithmic where every finite loss is positive.
    - `starts`: number [1] of the first step of each stage; losses of two stages do not compare.
    - `title`: one line above.
    """
    loss = np.asarray(losses, dtype=float)
    steps = np.arange(len(loss))
    finite = np.isfinite(loss)
    figure = new_figure(6.0, 3.6)
    axes = figure.subplots()
    marker = "o" if len(loss) <= 60 else ""
    shown = np.where(finite, loss, np.nan)
    ends = [*starts[1:], len(loss)]
    for start, end in zip(starts, ends, strict=True):
        label = "loss" if start == starts[0] else None
        part = slice(start, end)
        axes.plot(steps[part], shown[part], color="#2166ac", lw=1.2, marker=marker, ms=4,
                  label=label)  # fmt: skip
    if finite[starts[-1] :].any():
        for start, end in zip(starts, ends, strict=True):
            best = np.fmin.accumulate(shown[start:end])
            label = "best so far" if start == starts[0] else None
            axes.plot(steps[start:end], best, color="#b2182b", lw=1.0, ls="--", label=label)
        for number, start in enumerate(starts if len(starts) > 1 else (), 1):
            axes.axvline(start - 0.5, color="0.6", lw=0.8, ls=":")
            place = (start - 0.4, 0.98)
            axes.text(*place, f"stage {number}", fontsize=7, color="0.4", va="top", rotation=90,
                      transform=axes.get_xaxis_transform())  # fmt: skip
        if (loss[finite] > 0).all():
            axes.set_yscale("log")
            round_ticks(axes.yaxis)
        # A restored or interrupted run may end above its best.
        last = starts[-1] + int(np.nanargmin(shown[starts[-1] :]))
        axes.annotate(
            f"{shown[last]:.4g}", (last, float(shown[last])),
            (0, 6), textcoords="offset points", fontsize=8, ha="right",
        )  # fmt: skip
    tidy(axes)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("step", fontsize=9)
    axes.set_ylabel("loss [1]", fontsize=9)
    axes.set_title(title, fontsize=11)
    axes.legend(fontsize=8, frameon=False)
    save(figure, path)

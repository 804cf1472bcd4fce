"""Measured against simulated temperature curves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.ticker import MaxNLocator

from ._canvas import new_figure, save, tidy

_COLOURS = ("#b2182b", "#e08214", "#1b7837", "#2166ac", "#762a83")
_DOTS = 150  # more measured frames than this are thinned out for the eye


def representative(
    measured: Float[np.ndarray, "frames samples"], simulated: Float[np.ndarray, "frames samples"]
) -> dict[int, str]:
    """A handful of samples and why each was chosen.

    By the excursion, the largest departure from the first finite value [K]: the largest, the
    upper quartile, the median, the smallest; and the sample that is fitted worst. A sample that
    stands for two reasons is named by the first.
    """
    alive = np.flatnonzero(np.isfinite(measured).any(axis=0))
    if alive.size == 0:
        return {}
    columns = measured[:, alive]
    first = columns[np.isfinite(columns).argmax(axis=0), np.arange(alive.size)]
    excursion = np.nanmax(np.abs(columns - first), axis=0)
    residual = columns - simulated[:, alive]
    known = np.isfinite(residual)
    error = np.where(known, residual, 0.0) ** 2
    error = error.sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    order = alive[np.argsort(excursion)]
    picks = [
        (order[-1], "largest excursion"),
        (order[(3 * (alive.size - 1)) // 4], "upper quartile"),
        (order[(alive.size - 1) // 2], "median"),
        (order[0], "smallest excursion"),
        (alive[np.argmax(error)], "worst fit"),
    ]
    chosen: dict[int, str] = {}
    for sample, why in picks:
        chosen.setdefault(int(sample), why)
    return chosen


def figure_curves(
    path: Path,
    time: Float[np.ndarray, " frames"],
    measured: Float[np.ndarray, "frames samples"],
    simulated: Float[np.ndarray, "frames samples"],
    title: str,
) -> None:
    """Draws measured dots against simulated lines for a handful of samples, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `time`: the frames [s], (t,).
    - `measured`: temperatures [K], (t, s); NaN where a reading is missing.
    - `simulated`: temperatures [K], (t, s).
    - `title`: one line above; the root mean square of all residuals is added to it.

    The panel below shows the residuals of the same samples, and the band that holds the middle
    90 % of all samples in each frame.
    """
    residual = measured - simulated
    figure = new_figure(8.0, 5.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1.0))
    full = np.isfinite(residual).any(axis=1)
    if full.any():
        low, high = np.nanpercentile(residual[full], [5, 95], axis=1)
        lower.fill_between(time[full], low, high, color="0.87", lw=0, label="middle 90 % of all")
    step = max(1, len(time) // _DOTS)
    for (sample, why), colour in zip(
        representative(measured, simulated).items(), _COLOURS, strict=False
    ):
        dots = {"ls": "none", "marker": "o", "ms": 2.8, "mew": 0, "alpha": 0.55, "color": colour}
        upper.plot(time[::step], measured[::step, sample], **dots)
        name = f"{why} (sample {sample})"
        upper.plot(time, simulated[:, sample], color=colour, lw=1.5, label=name)
        lower.plot(time, residual[:, sample], color=colour, lw=0.8, alpha=0.85)
    upper.plot([], [], ls="none", marker="o", ms=3, color="0.4", label="measured")
    upper.plot([], [], color="0.4", lw=1.5, label="simulated")
    lower.axhline(0.0, color="0.3", lw=0.8)
    upper.set_ylabel("temperature [K]", fontsize=9)
    lower.set_ylabel("measured - simulated [K]", fontsize=8)
    lower.set_xlabel("time [s]", fontsize=9)
    for axes in (upper, lower):
        tidy(axes)
        axes.ticklabel_format(axis="y", useOffset=False)
    lower.yaxis.set_major_locator(MaxNLocator(4))
    upper.legend(fontsize=8, frameon=False)
    if full.any():
        lower.legend(fontsize=7, frameon=False, loc="upper right")
        rms = float(np.sqrt(np.nanmean(residual**2)))
        title = f"{title} (RMSE {rms:.3g} K over {measured.shape[1]} samples)"
    upper.set_title(title, fontsize=11)
    save(figure, path)

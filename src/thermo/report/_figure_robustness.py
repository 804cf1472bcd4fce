"""Repeated fits: how far they agree, and with the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from ._canvas import new_figure, save, tidy

_LEAST = 1e-5  # smaller values cannot be drawn on a logarithmic axis
_CROSS = {"marker": "x", "color": "#b2182b", "s": 42, "lw": 1.6, "zorder": 3}


@final
@dataclass(frozen=True)
class RepeatedFits:
    """Fits of one field from several starts.

    - `label`: of the group; `starts` (fits,): factors on first values [1].
    - `ratios` (fits,): median over the truth; `widths` (fits,): 5-95 % over the median [1].
    - `within`, `across`: standard deviations of log(median) from seeds and from starts [1]; NaN
      where they cannot be told apart.
    - `final_errors` (fits,): mean absolute residual at the last frame [K].
    - `published`: ratio [1], width [1] and final error [K] to compare with, or None.
    """

    label: str
    starts: Float[np.ndarray, " fits"]
    ratios: Float[np.ndarray, " fits"]
    widths: Float[np.ndarray, " fits"]
    within: float
    across: float
    final_errors: Float[np.ndarray, " fits"]
    published: tuple[float, float, float] | None


def figure_robustness(path: Path, groups: Sequence[RepeatedFits]) -> None:
    """Draws ratios, widths, parts of the scatter and final errors of repeated fits, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `groups`: one column in each panel.

    Source: paper, figure 3.
    """
    figure = new_figure(9.5, 6.8)
    panels = figure.subplots(2, 2)
    _strip(panels[0, 0], groups, "ratios", 0, "a  median / truth", logarithmic=False)
    panels[0, 0].axhline(1.0, color="0.3", lw=0.8, zorder=1)
    _strip(
        panels[0, 1],
        groups,
        "widths",
        1,
        f"b  5-95 % width / median (at least {_LEAST:g})",
        logarithmic=True,
    )
    _parts(panels[1, 0], groups)
    _strip(
        panels[1, 1], groups, "final_errors", 2, "d  error at the last frame [K]", logarithmic=True
    )
    for axes in panels.ravel():
        tidy(axes)
        axes.set_xticks(range(len(groups)), [group.label for group in groups], rotation=15)
        axes.set_xlim(-0.6, len(groups) - 0.4)
    handles = [
        *(panels[0, 0].scatter([], [], s=16, color=_colour(groups, start), label=f"start {start:g}")
          for start in _starts(groups)),
        panels[0, 0].scatter([], [], **_CROSS, label="published median"),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=6, fontsize=8, frameon=False)
    save(figure, path)


def _starts(groups: Sequence[RepeatedFits]) -> list[float]:
    return sorted({float(start) for group in groups for start in group.starts})


def _colour(groups: Sequence[RepeatedFits], start: float) -> tuple[float, float, float, float]:
    starts = _starts(groups)
    return mpl.colormaps["viridis"](0.9 * starts.index(start) / max(len(starts) - 1, 1))


def _strip(
    axes: Axes,
    groups: Sequence[RepeatedFits],
    name: str,
    place: int,
    title: str,
    *,
    logarithmic: bool,
) -> None:
    for column, group in enumerate(groups):
        values = getattr(group, name)
        values = np.maximum(values, _LEAST) if logarithmic else values
        beside = np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else np.zeros(1)
        order = np.argsort(group.starts, kind="stable")
        colours = [_colour(groups, float(start)) for start in group.starts[order]]
        axes.scatter(column + beside, values[order], c=colours, s=16, linewidths=0, zorder=2)
        if group.published is not None:
            axes.scatter([column], [group.published[place]], **_CROSS)
    if logarithmic:
        axes.set_yscale("log")
    axes.set_title(title, fontsize=10, loc="left")


def _parts(axes: Axes, groups: Sequence[RepeatedFits]) -> None:
    columns = np.arange(len(groups))
    for shift, name, colour in ((-0.18, "within", "#4575b4"), (0.18, "across", "#f46d43")):
        values = [100 * getattr(group, name) for group in groups]
        axes.bar(columns + shift, values, 0.34, color=colour, label=f"{name} starts")
    axes.set_title("c  standard deviation of the median [%]", fontsize=10, loc="left")
    axes.legend(fontsize=8, frameon=False)

"""Recovered fields beside the errors of the temperatures that follow from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ._canvas import colour_bar, new_figure, save, tidy
from ._object import draw_view, two_views
from ._render import View, visible


@final
@dataclass(frozen=True)
class TransferMap:
    """A recovered field and what follows from it.

    - `title`; `nodes` [m], `faces`; `ratio` (faces,) to the truth [1]; `areas` [m2].
    - `fitted`: positions [m] and absolute errors [K] of the fitted run at one moment.
    - `held_out`: positions [m] and mean absolute errors over time [K] of a run never fitted.
    """

    title: str
    nodes: Float[np.ndarray, "nodes 3"]
    faces: Int[np.ndarray, "faces 3"]
    ratio: Float[np.ndarray, " faces"]
    areas: Float[np.ndarray, " faces"]
    fitted: tuple[Float[np.ndarray, "samples 3"], Float[np.ndarray, " samples"]]
    held_out: tuple[Float[np.ndarray, "tested 3"], Float[np.ndarray, " tested"]]


def figure_transfer(path: Path, maps: Sequence[TransferMap]) -> None:
    """Draws field, its distribution, error of the fit and of a prediction, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `maps`: one column each.

    Source: paper, figure 2.
    """
    figure = new_figure(3.6 * len(maps), 10.5)
    panels = figure.subplots(4, len(maps), squeeze=False, height_ratios=(1.2, 0.8, 1.2, 1.2))
    for one, (top, middle, third, last) in zip(maps, panels.T, strict=True):
        view = two_views(one.nodes, one.faces)[0]
        _field(figure, top, view, one)
        top.set_title(one.title, fontsize=11)
        _distribution(middle, one)
        _errors(figure, third, view, one, one.fitted, "error of the fit [K]")
        _errors(figure, last, view, one, one.held_out, "mean error held out [K]")
    save(figure, path)


def _field(figure: Figure, axes: Axes, view: View, one: TransferMap) -> None:
    # Around the truth, and at least two per cent to each side: noise of a per mille is no pattern.
    reach = max(float(np.abs(one.ratio - 1).max()), 0.02)
    mappable = ScalarMappable(Normalize(1 - reach, 1 + reach), mpl.colormaps["RdBu_r"])
    draw_view(axes, view, np.asarray(mappable.to_rgba(one.ratio))[:, :3])
    colour_bar(figure, [axes], mappable, "field / truth")


def _distribution(axes: Axes, one: TransferMap) -> None:
    reach = max(float(np.abs(one.ratio - 1).max()), 0.02)
    share = 100 * one.areas / one.areas.sum()
    axes.hist(one.ratio, np.linspace(1 - reach, 1 + reach, 41).tolist(), weights=share, color="0.6")
    order = np.argsort(one.ratio)
    below = np.cumsum(one.areas[order]) - 0.5 * one.areas[order]
    low, middle, high = np.interp(
        np.array([0.05, 0.5, 0.95]) * one.areas.sum(), below, one.ratio[order]
    )
    axes.axvspan(low, high, color="#4575b4", alpha=0.2, lw=0)
    axes.axvline(middle, color="#4575b4", lw=1.5)
    axes.axvline(1.0, color="0.2", lw=1.0, ls=":")
    axes.set_title(f"median {middle:.4g}, 5-95 % {low:.4g} to {high:.4g}", fontsize=9)
    axes.set_xlabel("field / truth", fontsize=9)
    axes.set_ylabel("surface [%]", fontsize=9)
    tidy(axes)


def _errors(
    figure: Figure,
    axes: Axes,
    view: View,
    one: TransferMap,
    found: tuple[Float[np.ndarray, "samples 3"], Float[np.ndarray, " samples"]],
    label: str,
) -> None:
    points, errors = found
    norm = Normalize(0.0, float(np.nanmax(errors, initial=0.0)) or 1.0)
    palette = mpl.colormaps["plasma"]
    draw_view(axes, view, np.full((len(one.faces), 3), 0.88))
    slack = 0.02 * float(np.ptp(one.nodes, axis=0).max())
    seen = np.flatnonzero(visible(view, points, slack) & np.isfinite(errors))
    order = seen[np.argsort(errors[seen])]
    flat = points[order] @ view.camera.axes[:2].T
    size = float(np.clip(130.0 / np.sqrt(max(len(points), 1)), 2.0, 7.0)) ** 2
    axes.scatter(*flat.T, c=errors[order], norm=norm, cmap=palette, s=size, linewidths=0)
    colour_bar(figure, [axes], ScalarMappable(norm, palette), label)

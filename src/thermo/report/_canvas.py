"""The look of all figures, and how they are written."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from thermo.observe import write_whole

_DPI = 150


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of this size [inch], without any state shared with `pyplot`."""
    figure = Figure(figsize=(width, height), dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def tidy(axes: Axes) -> None:
    """Thin frame on two sides and a faint grid."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", lw=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8)


def round_ticks(axis: Axis) -> None:
    """Ticks of a logarithmic axis at 1, 2 and 5 times the powers of ten, as plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def colour_bar(figure: Figure, axes: list[Axes], mappable: ScalarMappable, label: str) -> None:
    """A colour bar to the right of the axes."""
    bar = figure.colorbar(mappable, ax=axes, shrink=0.8, pad=0.02, aspect=25)
    bar.set_label(label, fontsize=9)
    bar.ax.tick_params(labelsize=8)
    if isinstance(mappable.norm, LogNorm):
        round_ticks(bar.ax.yaxis)
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]


def save(figure: Figure, path: Path) -> None:
    """Writes the figure as PNG, whole or not at all."""
    # Without a stamp of the program, equal figures are equal files.
    with write_whole(path) as temporary, mpl.rc_context({"savefig.bbox": None}):
        figure.savefig(temporary, format="png", dpi=_DPI, metadata={"Software": None})

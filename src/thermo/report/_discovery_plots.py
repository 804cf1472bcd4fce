"""Interactive figures on what is missing."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from plotly.graph_objects import Bar, Figure, Heatmap, Scatter, Scatter3d
from plotly.subplots import make_subplots

from ._identifiability_plots import _titled

_ABOVE, _BELOW = "#24588f", "#c4c4c4"
# Scores below this are drawn there, so that one of nearly zero does not stretch the axis [1].
_LEAST = 0.01

Record = Mapping[str, Any]


def spoken(name: str) -> str:
    """The name of a candidate or of a quantity in words."""
    return name.replace("_", " ")


def score_bars(found: Sequence[Record], threshold: float) -> Figure:
    """Sizes of scores [1] with their threshold, the largest at the top."""
    order = sorted(found, key=lambda one: -abs(one["score"]))
    sizes = np.abs([one["score"] for one in order])
    drawn = np.maximum(sizes, _LEAST)
    bars = Bar(
        x=drawn,
        y=[html.escape(spoken(one["name"])) for one in order],
        orientation="h",
        marker_color=[_ABOVE if size > threshold else _BELOW for size in sizes],
        text=[f"{size:.3g}" for size in sizes],
        textposition="outside",
        cliponaxis=False,
        hovertext=[f"score {one['score']:+.3g}" for one in order],
    )
    figure = _titled(
        Figure(bars), "Scores of round 1, greyed below the threshold",
        "size of the score [standard deviations]", "", 150 + 26 * len(order),
    )  # fmt: skip
    # The template draws lines of no width unless they state one.
    figure.add_vline(x=threshold, line_dash="dash", line_color="#a3242b", line_width=2, opacity=1.0)
    low, high = min(drawn.min(), threshold), max(drawn.max(), threshold)
    if high > 100 * low:
        ends = [np.log10(low) - 0.3, np.log10(high) + 0.4]
        figure.update_xaxes(type="log", exponentformat="power", dtick=1, range=ends)
    else:
        figure.update_xaxes(range=[0, 1.15 * high])
    return figure.update_yaxes(autorange="reversed", type="category")


def chance_curve(drawn: Record, threshold: float, found: float | None) -> Figure:
    """Chance that the largest of all scores passes a size where nothing is missing [1]."""
    passed = 1 - np.asarray(drawn["chance"])
    line = Scatter(x=drawn["value"], y=passed, mode="lines", line={"color": _ABOVE, "width": 2})
    figure = _titled(
        Figure(line), "Largest score where nothing is missing, by simulation",
        "largest score of all [standard deviations]", "chance that it is larger",
    )  # fmt: skip
    marks = {"threshold": (threshold, "#a3242b", "dash")}
    # Far off, the score that was found would leave nothing to see of the curve.
    if found is not None and found < 3 * threshold:
        marks["found"] = (found, "#1b6e3c", "solid")
    for name, (at, colour, dash) in marks.items():
        figure.add_vline(
            x=at, line_dash=dash, line_color=colour, line_width=2, opacity=1.0, annotation_text=name
        )
    return figure.update_yaxes(type="log", exponentformat="power")


def residual_maps(run: str, found: Record) -> Figure:
    """Root mean square of each sample over time [K], before and after on one scale of colours."""
    points = np.array(found["points"], float)
    values = {
        side: np.array(one, float) for side, one in found["by_sample"].items() if one is not None
    }
    finite = np.concatenate([one[np.isfinite(one)] for one in values.values()])
    most = float(finite.max()) if finite.size else 1.0
    specs = [[{"type": "scene"} for _ in values]]
    figure = make_subplots(rows=1, cols=len(values), specs=specs, subplot_titles=list(values))
    for column, one in enumerate(values.values(), 1):
        read = np.isfinite(one)  # a sample without a valid reading has nothing to show
        (x, y, z), seen = points[read].T, one[read]
        marker = {"size": 4, "color": seen, "cmin": 0.0, "cmax": most, "colorscale": "Viridis",
                  "showscale": column == 1, "colorbar": {"title": "rms [K]"}}  # fmt: skip
        hover = [f"{value:.3g} K" for value in seen]
        cloud = Scatter3d(x=x, y=y, z=z, mode="markers", hovertext=hover, marker=marker)
        figure.add_trace(cloud, row=1, col=column)
    figure.update_scenes(
        aspectmode="data", xaxis_title="x [m]", yaxis_title="y [m]", zaxis_title="z [m]"
    )
    return figure.update_layout(
        title=f"{html.escape(run)}: simulation less readings, by sample",
        template="simple_white", height=460, margin={"t": 80, "r": 20}, showlegend=False,
    )  # fmt: skip


def residual_curves(run: str, found: Record, noise: float | None) -> Figure:
    """Root mean square over the samples at each time [K], before and after, and that of noise."""
    colours = {"before": "#a3242b", "after": "#1b6e3c"}
    lines = [
        Scatter(
            x=found["time"], y=one, mode="lines", name=side,
            line={"color": colours[side], "width": 2},
        )
        for side, one in found["by_frame"].items()
        if one is not None
    ]  # fmt: skip
    title = f"{html.escape(run)}: simulation less readings over time"
    figure = _titled(Figure(lines), title, "time [s]", "rms [K]")
    if noise is not None:
        figure.add_hline(
            y=noise, line_dash="dash", line_color="#6b6b6b", line_width=2, opacity=1.0,
            annotation_text="noise",
        )  # fmt: skip
    return figure


def alias_matrix(found: Mapping[str, Mapping[str, float]]) -> Figure:
    """How alike the effects of two candidates are, 0 to 1 [1]."""
    names = [html.escape(spoken(one)) for one in found]
    values = [[row[other] for other in found] for row in found.values()]
    drawn = Heatmap(
        x=names, y=names, z=values, zmin=0.0, zmax=1.0, colorscale="Blues",
        text=[[f"{one:.2f}" for one in row] for row in values], texttemplate="%{text}",
        colorbar={"title": "cosine"},
    )  # fmt: skip
    figure = _titled(
        Figure(drawn), "How alike two effects are in these runs", "", "", 250 + 26 * len(names)
    )
    return figure.update_yaxes(autorange="reversed", type="category").update_xaxes(type="category")


def held_out_bars(found: Mapping[str, Record]) -> Figure:
    """Differences from the readings before and after, beside the noise, by run [K]."""
    parts = {"rms_before": ("before", "#a3242b"), "rms_after": ("after", "#1b6e3c"),
             "noise": ("noise", _BELOW)}  # fmt: skip
    bars = [
        Bar(
            x=[html.escape(name) for name in found],
            y=[one[key] for one in found.values()],
            name=word,
            marker_color=colour,
            text=["" if one[key] is None else f"{one[key]:.3g}" for one in found.values()],
            textposition="outside",
            cliponaxis=False,
        )
        for key, (word, colour) in parts.items()
    ]
    return _titled(
        Figure(bars), "Simulation less readings, on runs that were not fitted", "run", "rms [K]"
    ).update_xaxes(type="category")

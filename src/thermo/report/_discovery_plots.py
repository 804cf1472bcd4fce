"""Interactive figures on what is missing."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from plotly.graph_objects import Bar, Figure, Heatmap

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

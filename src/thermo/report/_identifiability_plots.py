"""Interactive figures on what the data identify."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from plotly.graph_objects import Bar, Figure, Heatmap, Mesh3d, Scatter, Scatter3d

from thermo.identify import LEVEL

_COLOURS = {
    "identified": "#1b6e3c",
    "weak": "#d08a00",
    "not_identified": "#a3242b",
    "at_bound": "#a3242b",
}
_HEIGHT = 340

Record = Mapping[str, Any]


def _titled(figure: Figure, title: str, across: str, up: str, height: int = _HEIGHT) -> Figure:
    figure.update_layout(
        title=title, template="simple_white", height=height, margin={"t": 60, "r": 20}
    )
    figure.update_xaxes(title=across)
    figure.update_yaxes(title=up)
    return figure


def shares(parameters: Record) -> Figure:
    """Which part of each unknown's prior variance the data take away [1]."""
    names = list(parameters)
    bars = Bar(
        x=[parameters[name]["informed_by_data"] for name in names],
        y=names,
        orientation="h",
        marker_color=[_COLOURS[parameters[name]["verdict"]] for name in names],
    )
    figure = _titled(
        Figure(bars), "Share of the prior's variance that the data take away", "share", "",
        140 + 40 * len(names),
    )  # fmt: skip
    return figure.update_xaxes(range=[0, 1])


def spectrum(found: Record) -> Figure:
    """Eigenvalues of the information in units of the prior's [1], with the line at 1."""
    sizes = np.asarray(found["eigenvalues"], float)
    # What lies below what the slopes can show is drawn there.
    least = max(float(found["hidden"]), 1e-12)
    words = [
        "<br>".join(f"{name}: {part:+.2f}" for name, part in zip(found["names"], row, strict=True))
        for row in np.asarray(found["directions"], float).T
    ]
    dots = Scatter(
        x=np.arange(1, len(sizes) + 1),
        y=np.maximum(sizes, least),
        mode="markers",
        marker={"size": 10, "color": ["#1b6e3c" if size > 1 else "#a3242b" for size in sizes]},
        hovertext=words,
    )
    figure = _titled(
        Figure(dots), "Directions: above 1 the data lead, below it the prior", "direction",
        "eigenvalue",
    )  # fmt: skip
    figure.add_hline(y=1.0, line_dash="dash", line_color="#666", line_width=1)
    figure.update_xaxes(dtick=1 if len(sizes) < 20 else None)
    drawn = np.log10([*np.maximum(sizes, least), 1.0])
    figure.update_yaxes(range=[drawn.min() - 0.5, drawn.max() + 0.5])
    return figure.update_yaxes(type="log", exponentformat="power")


def correlations(found: Record) -> Figure:
    """Correlation of the errors that are left [1]."""
    names = list(found["names"])
    drawn = Heatmap(
        z=np.asarray(found["correlation"], float), x=names, y=names, zmin=-1, zmax=1,
        colorscale="RdBu", texttemplate="%{z:.2f}" if len(names) < 10 else None,
    )  # fmt: skip
    height = max(_HEIGHT, min(160 + 40 * len(names), 700))
    figure = _titled(Figure(drawn), "Correlation of the errors that are left", "", "", height)
    return figure.update_yaxes(autorange="reversed")


def profile(name: str, found: Record, unit: str) -> Figure:
    """Rise of chi squared along a value [1], the parabola of the slopes beside it."""
    values, rises = (np.asarray(found[key], float) for key in ("values", "rises"))
    dense = np.geomspace(values.min(), values.max(), 100)
    half = np.log(found["linear"][1] / found["best"]) if found["linear"][1] else np.inf
    parabola = LEVEL * (np.log(dense / found["best"]) / half) ** 2
    figure = Figure([
        Scatter(x=values, y=rises, mode="lines+markers", name="profile"),
        Scatter(x=dense, y=parabola, mode="lines", name="from the slopes", line={"dash": "dot"}),
    ])  # fmt: skip
    across = name if unit == "1" else f"{name} [{unit}]"
    _titled(figure, f"{name}: {found['kind']}", across, "rise of chi squared")
    figure.add_hline(y=LEVEL, line_dash="dash", line_color="#666", line_width=1)
    return figure.update_yaxes(range=[0, 2 * LEVEL])


def response(run: str, found: Record) -> Figure:
    """Samples [m] coloured by how far a reading moves with the logarithm of each unknown [K]."""
    points = np.asarray(found["points"], float)
    names = list(found["response"])
    clouds = [
        Scatter3d(
            x=points[:, 0], y=points[:, 1], z=points[:, 2], mode="markers", visible=number == 0,
            name=name, marker={
                "size": 4, "color": found["response"][name], "colorscale": "Viridis", "cmin": 0,
                "colorbar": {"title": "K"},
            },
        )
        for number, name in enumerate(names)
    ]  # fmt: skip
    title = f"{run}: change of a reading when the unknown changes by a factor e"
    return _in_space(Figure(clouds), title, names)


def field_maps(name: str, maps: Record, surface: Record) -> Figure:
    """A field over the surface [m], how well it is known, and what the data tell of it [1]."""
    points, faces = np.asarray(surface["points"], float), np.asarray(surface["faces"], int)
    drawn = [
        Mesh3d(
            x=points[:, 0], y=points[:, 1], z=points[:, 2],
            i=faces[:, 0], j=faces[:, 1], k=faces[:, 2],
            intensity=values, intensitymode="cell", colorscale="Viridis", flatshading=True,
            visible=number == 0, name=word, colorbar={"title": word},
        )
        for number, (word, values) in enumerate(maps.items())
    ]  # fmt: skip
    return _in_space(Figure(drawn), f"{name} on the object", list(maps))


def _in_space(figure: Figure, title: str, names: list[str]) -> Figure:
    """Traces in three dimensions [m], of which a menu shows one."""
    buttons = [
        {
            "label": name,
            "method": "update",
            "args": [{"visible": [other == name for other in names]}],
        }
        for name in names
    ]
    return figure.update_layout(
        title=title, template="simple_white", height=520, margin={"t": 60, "r": 20},
        showlegend=False,
        scene={"aspectmode": "data", "xaxis_title": "x [m]", "yaxis_title": "y [m]",
               "zaxis_title": "z [m]"},
        updatemenus=[{"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.0}],
    )  # fmt: skip

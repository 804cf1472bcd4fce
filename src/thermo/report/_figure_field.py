"""Picture of a field on the object."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, Int
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize

from ._canvas import colour_bar, new_figure, save
from ._object import draw_scale, draw_view, two_views

_UNKNOWN = 0.82  # grey of a face without a value


def colour_norm(values: Float[np.ndarray, " values"]) -> Normalize:
    """The range of the finite values; logarithmic if they are positive and exceed a decade."""
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return Normalize(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    if low > 0 and high > 10 * low:
        return LogNorm(low, high)
    # A uniform field still needs a range; 2 % of it keeps the ticks readable.
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        pad = 0.02 * max(abs(low), abs(high)) or 1.0
        return Normalize(low - pad, high + pad)
    return Normalize(low, high)


def figure_field(
    path: Path,
    nodes: Float[np.ndarray, "nodes 3"],
    faces: Int[np.ndarray, "faces corners"],
    values_on_faces: Float[np.ndarray, " faces"],
    title: str,
    label: str,
) -> None:
    """Draws a field on the object, from two opposite sides, with a colour bar, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `nodes`: positions [m], (n, 3).
    - `faces`: boundary faces, ordered counter-clockwise from outside, (f, 3) or (f, 6).
    - `values_on_faces`: the field on each face in the unit that `label` states, (f,). A face
      without a finite value is grey.
    - `title`: one line above.
    - `label`: name, symbol and unit of the field, beside the colour bar.

    The colours are logarithmic where positive values exceed a decade.
    """
    norm = colour_norm(values_on_faces)
    mappable = ScalarMappable(norm, mpl.colormaps["viridis"])
    colours = np.full((len(values_on_faces), 3), _UNKNOWN)
    known = np.isfinite(values_on_faces)
    colours[known] = np.asarray(mappable.to_rgba(values_on_faces[known]))[:, :3]
    views = two_views(nodes, faces)
    tall = float(np.clip(views[0].camera.height / views[0].camera.width, 0.45, 1.3))
    figure = new_figure(9.0, 4.0 * tall + 1.0)
    both = figure.subplots(1, 2)
    for axes, view in zip(both, views, strict=True):
        draw_view(axes, view, colours)
        draw_scale(axes, view)
    colour_bar(figure, list(both), mappable, label)
    figure.suptitle(title, fontsize=11)
    save(figure, path)

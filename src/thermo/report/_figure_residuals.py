"""Map of the residuals on the object."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from jaxtyping import Float, Int
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from ._canvas import colour_bar, new_figure, save
from ._object import draw_scale, draw_view, two_views
from ._render import visible


def _dot(count: int) -> float:
    """Diameter of a dot [pt] such that `count` of them do not cover each other."""
    return float(np.clip(220.0 / np.sqrt(max(count, 1)), 2.5, 9.0))


def figure_residuals(
    path: Path,
    points: Float[np.ndarray, "samples 3"],
    nodes: Float[np.ndarray, "nodes 3"],
    faces: Int[np.ndarray, "faces corners"],
    rms_per_sample: Float[np.ndarray, " samples"],
    title: str = "Residual of the fit",
) -> None:
    """Draws the root mean square residual of each sample on the object, as PNG.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `points`: positions of the samples [m], (s, 3).
    - `nodes`: positions of the nodes [m], (n, 3).
    - `faces`: boundary faces, ordered counter-clockwise from outside, (f, 3) or (f, 6).
    - `rms_per_sample`: root mean square over the frames [K], (s,). A sample without a finite
      value is left out.
    - `title`: one line above.
    """
    known = np.isfinite(rms_per_sample)
    points, rms = points[known], rms_per_sample[known]
    norm = Normalize(0.0, float(rms.max(initial=0.0)) or 1.0)
    palette = mpl.colormaps["plasma"]
    views = two_views(nodes, faces)
    # A sample may lie a little inside the meshed surface and still belong to it.
    slack = 0.02 * float(np.ptp(nodes, axis=0).max())
    tall = float(np.clip(views[0].camera.height / views[0].camera.width, 0.45, 1.3))
    figure = new_figure(9.0, 4.0 * tall + 1.0)
    both = figure.subplots(1, 2)
    for axes, view in zip(both, views, strict=True):
        draw_view(axes, view, np.full((len(faces), 3), 0.88))
        seen = np.flatnonzero(visible(view, points, slack))
        flat = points[seen] @ view.camera.axes[:2].T
        # The worst samples are drawn last, on top.
        order = np.argsort(rms[seen])
        axes.scatter(
            *flat[order].T, c=rms[seen][order], norm=norm, cmap=palette,
            s=_dot(len(rms)) ** 2, linewidths=0, zorder=2,
        )  # fmt: skip
        draw_scale(axes, view)
    colour_bar(figure, list(both), ScalarMappable(norm, palette), "RMS residual [K]")
    mean = float(np.sqrt(np.mean(rms**2))) if rms.size else float("nan")
    figure.suptitle(f"{title}: {mean:.3g} K over {len(rms)} samples", fontsize=11)
    save(figure, path)

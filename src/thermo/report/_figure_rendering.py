"""How a thermal picture comes about: samples, vertices, pixels."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize

from thermo.imaging import (
    NEAREST,
    Camera,
    PixelMap,
    interpolated,
    look,
    project,
    render,
    sample_weights,
    seen_exactly,
)
from thermo.mesh import Surface

from ._canvas import colour_bar, new_figure, save
from ._figure_field import colour_norm

_PALETTE = mpl.colormaps["inferno"]
_EDGE = 0.35  # pt
_AROUND = 0.06  # of the object's size in the picture, left free round it


def figure_rendering(
    path: Path,
    camera: Camera,
    surface: Surface,
    samples: Float[np.ndarray, "samples 3"],
    values: Float[np.ndarray, " samples"],
    *,
    k: int = NEAREST,
    title: str = "",
    label: str = "temperature T [K]",
) -> None:
    """Draws the steps from sparse samples to a dense picture, side by side, as PNG.

    Left the samples that the camera sees, where they are projected; in the middle the edges of the
    triangles that it sees, coloured by what their vertices take from the samples; on the right the
    picture. One scale of colours serves all.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `camera`, `surface`: what looks at what [m].
    - `samples`: positions, (samples, 3) [m]. `values`: their temperatures, (samples,) [K].
    - `k`: samples that a vertex takes its temperature from [1].
    - `title`: one line above. `label`: name, symbol and unit of the values.

    Raises `InputError` as `look` and `sample_weights` do.

    Source: paper, appendix A.1, the figure of the thermal rendering pipeline.
    """
    at_vertices = interpolated(sample_weights(samples, surface.vertices, k=k), values[None])[0]
    pixel_map = look(camera, surface)
    picture = render(pixel_map, at_vertices)
    norm = colour_norm(values)
    mappable = ScalarMappable(norm, _PALETTE)
    left, right, top, bottom = _frame(pixel_map)
    tall = float(np.clip((bottom - top) / (right - left), 0.4, 1.6))
    figure = new_figure(10.5, 3.1 * tall + (0.9 if title else 0.6))
    three = list(figure.subplots(1, 3))
    names = ("visible samples", "mesh", "dense picture")
    for axes, name in zip(three, names, strict=True):
        axes.set_title(name, fontsize=9)
        axes.set_aspect("equal")
        axes.set_xlim(left, right)
        axes.set_ylim(bottom, top)
        axes.set_axis_off()
    grey = np.where(np.isfinite(picture), 0.93, np.nan)
    three[0].imshow(grey, cmap="gray", vmin=0.0, vmax=1.0)
    _draw_samples(three[0], camera, samples, values, seen_exactly(camera, surface, samples), norm)
    _draw_edges(three[1], camera, surface, pixel_map, at_vertices, norm)
    three[2].imshow(picture, norm=norm, cmap=_PALETTE, interpolation="nearest")
    for axes in three:  # `imshow` set its own
        axes.set_xlim(left, right)
        axes.set_ylim(bottom, top)
    colour_bar(figure, three, mappable, label)
    if title:
        figure.suptitle(title, fontsize=11)
    save(figure, path)


def _frame(pixel_map: PixelMap) -> tuple[float, float, float, float]:
    """Left, right, upper and lower end of what is shown [px]: the object with a margin."""
    rows, columns = pixel_map.size()
    if len(pixel_map.hit) == 0:
        return -0.5, columns - 0.5, -0.5, rows - 0.5
    row, column = np.divmod(pixel_map.hit, columns)
    gap = _AROUND * max(np.ptp(row), np.ptp(column), 1) + 0.5
    return (
        float(column.min() - gap), float(column.max() + gap),
        float(row.min() - gap), float(row.max() + gap),
    )  # fmt: skip


def _draw_samples(
    axes: Axes,
    camera: Camera,
    samples: np.ndarray,
    values: np.ndarray,
    seen: Bool[np.ndarray, " samples"],
    norm: Normalize,
) -> None:
    pixels, _ = project(camera, samples[seen])
    dot = float(np.clip(90.0 / np.sqrt(max(seen.sum(), 1)), 2.0, 8.0))
    axes.scatter(
        pixels[:, 0], pixels[:, 1], c=values[seen], norm=norm, cmap=_PALETTE,
        s=dot**2, edgecolors="0.3", linewidths=0.2,
    )  # fmt: skip


def _draw_edges(
    axes: Axes,
    camera: Camera,
    surface: Surface,
    pixel_map: PixelMap,
    at_vertices: np.ndarray,
    norm: Normalize,
) -> None:
    """The edges of triangles that some pixel sees, each in the mean colour of its ends."""
    seen = np.unique(pixel_map.triangle[pixel_map.triangle >= 0])
    faces = surface.triangles[seen]
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    pixels, _ = project(camera, surface.vertices)
    lines = LineCollection(
        list(pixels[edges]), array=at_vertices[edges].mean(axis=1), norm=norm,
        cmap=_PALETTE, linewidths=_EDGE if len(edges) > 4000 else 2 * _EDGE,
    )  # fmt: skip
    axes.add_collection(lines)

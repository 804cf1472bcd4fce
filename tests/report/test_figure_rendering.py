from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import trimesh
from matplotlib import image

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at
from thermo.mesh import Surface
from thermo.report._figure_rendering import figure_rendering

BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
SURFACE = Surface(np.asarray(BALL.vertices, float), np.asarray(BALL.faces))
POSE = looking_at(np.array([0.0, 0.0, 0.3]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
CAMERA = Camera(80, 60, [150.0, 150.0], [39.5, 29.5], POSE)
SAMPLES = np.asarray(trimesh.sample.sample_surface(BALL, 60, seed=0)[0])


def holds(pixels: np.ndarray, colour: np.ndarray) -> int:
    return int((np.abs(pixels - colour).max(axis=-1) < 0.03).sum())


def test_three_panels_of_one_scale(tmp_path: Path) -> None:
    path = tmp_path / "new" / "steps.png"
    # The left half of what the camera sees is cold and the right half hot.
    values = np.where(SAMPLES[:, 0] < 0, 290.0, 310.0)
    figure_rendering(path, CAMERA, SURFACE, SAMPLES, values, title="ball", k=1)
    assert list(path.parent.iterdir()) == [path]
    pixels = image.imread(path)[..., :3]
    ends = mpl.colormaps["inferno"]([0.0, 1.0])[:, :3]
    wide = pixels.shape[1]
    panels = [
        pixels[:, int(a * wide) : int(b * wide)] for a, b in ((0, 0.3), (0.31, 0.6), (0.61, 0.9))
    ]
    cold, hot = ([holds(one, colour) for one in panels] for colour in ends)
    # Dots, then lines, then whole halves.
    assert min(cold) > 60 and min(hot) > 60
    assert cold[2] > 5 * cold[0] and hot[2] > 5 * hot[0]
    assert 0.6 < cold[2] / hot[2] < 1.6
    dense = panels[2]
    where = [np.argwhere(np.abs(dense - one).max(axis=-1) < 0.03)[:, 1].mean() for one in ends]
    assert where[0] < where[1]


def test_samples_that_are_hidden_are_not_drawn(tmp_path: Path) -> None:
    values = np.where(SAMPLES[:, 2] < -0.01, 310.0, 300.0)
    figure_rendering(tmp_path / "a.png", CAMERA, SURFACE, SAMPLES, values, k=1)
    cold, hot = mpl.colormaps["inferno"]([0.0, 1.0])[:, :3]
    pixels = image.imread(tmp_path / "a.png")[..., :3]
    dots = pixels[:, : int(0.3 * pixels.shape[1])]
    assert holds(dots, hot) == 0 and holds(dots, cold) > 500


def test_too_few_samples_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="from 1 to 2"):
        figure_rendering(tmp_path / "a.png", CAMERA, SURFACE, SAMPLES[:2], np.array([290.0, 300.0]))
    assert not list(tmp_path.iterdir())

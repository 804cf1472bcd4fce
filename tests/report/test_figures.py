from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import trimesh
from matplotlib import image
from matplotlib.colors import LogNorm

from thermo.report import (
    RepeatedFits,
    TransferMap,
    figure_curves,
    figure_field,
    figure_history,
    figure_residuals,
    figure_robustness,
    figure_transfer,
)
from thermo.report._figure_curves import representative
from thermo.report._figure_field import colour_norm

BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.03)
NODES, FACES = np.asarray(BALL.vertices), np.asarray(BALL.faces)
RNG = np.random.default_rng(3)


def picture(path: Path) -> np.ndarray:
    """Reads the picture back; nothing else may stand in its folder."""
    assert list(path.parent.iterdir()) == [path]
    return image.imread(path)[..., :3]


def holds(pixels: np.ndarray, colour: tuple[float, ...], tolerance: float = 0.02) -> int:
    return int((np.abs(pixels - np.array(colour[:3])).max(axis=-1) < tolerance).sum())


def hue_pixels(pixels: np.ndarray) -> int:
    return int((np.ptp(pixels, axis=-1) > 0.15).sum())


def test_field_of_two_values(tmp_path: Path) -> None:
    left = NODES[FACES].mean(axis=1)[:, 0] < 0
    path = tmp_path / "new" / "field.png"
    figure_field(path, NODES, FACES, np.where(left, 4.0, 1.0), "ball", "k [W/m/K]")
    pixels = picture(path)
    assert pixels.shape[1] == 1350
    panels = pixels[:, : int(0.85 * pixels.shape[1])]
    yellow = (panels[..., 0] > panels[..., 2] + 0.3).sum()
    purple = (panels[..., 2] > panels[..., 1] + 0.15).sum()
    # The two views are opposite, so that each half shows equally often.
    assert yellow > 50_000 and purple > 50_000
    assert 0.8 < yellow / purple < 1.25


def test_faces_without_a_value_are_grey(tmp_path: Path) -> None:
    figure_field(tmp_path / "a.png", NODES, FACES, np.full(len(FACES), np.nan), "t", "k [1]")
    pixels = picture(tmp_path / "a.png")
    # Only the colour bar and the small axes have colours.
    assert hue_pixels(pixels[:, : int(0.85 * pixels.shape[1])]) < 3000


def test_quadratic_faces_draw_as_their_corners(tmp_path: Path) -> None:
    values = RNG.uniform(1.0, 2.0, len(FACES))
    six = np.hstack([FACES, np.zeros_like(FACES)])
    figure_field(tmp_path / "a" / "a.png", NODES, FACES, values, "t", "k [1]")
    figure_field(tmp_path / "b" / "b.png", NODES, six, values, "t", "k [1]")
    assert (tmp_path / "a" / "a.png").read_bytes() == (tmp_path / "b" / "b.png").read_bytes()


def test_colours_are_logarithmic_beyond_a_decade() -> None:
    assert isinstance(colour_norm(np.array([0.1, 1.5])), LogNorm)
    assert not isinstance(colour_norm(np.array([0.1, 0.9])), LogNorm)
    assert not isinstance(colour_norm(np.array([-1.0, 100.0])), LogNorm)


@pytest.mark.parametrize("values", [[0.2, 0.2], [0.0, 0.0], [-3.0], [np.nan, 5.0], [np.nan]])
def test_colours_of_a_uniform_field_have_a_range(values: list[float]) -> None:
    norm = colour_norm(np.array(values))
    assert norm.vmin is not None and norm.vmax is not None and norm.vmin < norm.vmax
    if np.isfinite(values).any():
        assert norm(np.nanmax(values)) == pytest.approx(0.5)


def test_residual_map_shows_the_worst_sample(tmp_path: Path) -> None:
    points = 0.03 * RNG.normal(size=(200, 3))
    points *= 0.03 / np.linalg.norm(points, axis=1, keepdims=True)
    rms = np.full(200, 0.05)
    # In the middle of the first view.
    points[0] = 0.03 * np.array([0.44, -0.76, 0.47])
    colour = mpl.colormaps["plasma"](1.0)
    shown = []
    for worst in (0.05, 0.5):
        rms[0] = worst
        rms[1] = np.nan
        path = tmp_path / str(worst) / "residuals.png"
        figure_residuals(path, points, NODES, FACES, rms)
        pixels = picture(path)
        shown.append(holds(pixels[:, : int(0.85 * pixels.shape[1])], colour))
    # At 0.05 K all samples have the colour of the maximum, at 0.5 K only the one.
    assert shown[0] > 20 * shown[1] > 0


def test_residual_map_hides_what_lies_behind(tmp_path: Path) -> None:
    points = 0.03 * np.array([[0.44, -0.76, 0.47]])
    figure_residuals(tmp_path / "a.png", points, NODES, FACES, np.array([0.1]))
    pixels = picture(tmp_path / "a.png")
    panel = int(0.42 * pixels.shape[1])
    colour = mpl.colormaps["plasma"](1.0)
    assert holds(pixels[:, :panel], colour) > 50
    assert holds(pixels[:, panel : 2 * panel], colour) == 0


def test_residual_map_of_no_finite_sample(tmp_path: Path) -> None:
    figure_residuals(tmp_path / "a.png", NODES[:2], NODES, FACES, np.full(2, np.nan))
    assert picture(tmp_path / "a.png").shape[2] == 3


def curves() -> tuple[np.ndarray, np.ndarray]:
    """Five samples with excursions 0 to 4 K over 11 frames; the third is fitted badly."""
    ramp = np.linspace(0.0, 1.0, 11)[:, None] * np.arange(5.0)
    measured = 295.0 + ramp
    simulated = measured.copy()
    simulated[:, 3] += 0.5
    return measured, simulated


def test_representative_samples() -> None:
    measured, simulated = curves()
    measured[0, 2] = measured[5, 0] = np.nan
    assert representative(measured, simulated) == {
        4: "largest excursion",
        3: "upper quartile",
        2: "median",
        0: "smallest excursion",
    }
    simulated[:, 1] += 2.0
    assert representative(measured, simulated)[1] == "worst fit"


def test_samples_without_a_reading_are_not_chosen() -> None:
    measured, simulated = curves()
    measured[:, 4] = np.nan
    assert 4 not in representative(measured, simulated)
    assert representative(np.full((3, 2), np.nan), np.zeros((3, 2))) == {}


def test_curves(tmp_path: Path) -> None:
    measured, simulated = curves()
    measured[4, :] = np.nan
    figure_curves(tmp_path / "a.png", np.arange(11.0), measured, simulated, "heating")
    assert hue_pixels(picture(tmp_path / "a.png")) > 2000


def test_curves_without_a_finite_reading(tmp_path: Path) -> None:
    nothing = np.full((3, 2), np.nan)
    figure_curves(tmp_path / "a.png", np.arange(3.0), nothing, np.zeros((3, 2)), "none")
    assert hue_pixels(picture(tmp_path / "a.png")) == 0


@pytest.mark.parametrize("losses", [[3.0, 2.0, 2.5], [1.0], [np.nan, 1.0, -1.0], [np.nan], []])
def test_history(tmp_path: Path, losses: list[float]) -> None:
    figure_history(tmp_path / "a.png", losses)
    pixels = picture(tmp_path / "a.png")
    assert pixels.shape[:2] == (540, 900)
    assert hue_pixels(pixels) > 50


def test_the_stages_of_a_history_are_parted_and_numbered(tmp_path: Path) -> None:
    losses = [9.0, 4.0, 3.0, 2.0]
    for name, starts in (("one", (0,)), ("two", (0, 2)), ("three", (0, 1, 2))):
        figure_history(tmp_path / name / "a.png", losses, starts)
    grey = (0.4, 0.4, 0.4)
    one, two, three = (
        holds(picture(tmp_path / name / "a.png"), grey) for name in ("one", "two", "three")
    )
    assert one < two < three


def repeated(label: str, **more: object) -> RepeatedFits:
    starts = np.repeat([0.1, 10.0], 2)
    numbers = {"ratios": np.full(4, 1.0), "widths": np.zeros(4), "final_errors": np.full(4, 0.01)}
    known = {"within": 0.001, "across": 0.002, "published": (1.1, 0.7, 0.1)}
    return RepeatedFits(**{"label": label, "starts": starts, **numbers, **known, **more})


def test_repeated_fits_are_drawn_by_start(tmp_path: Path) -> None:
    alone = repeated("b", published=None, within=np.nan, across=np.nan)
    figure_robustness(tmp_path / "new" / "a.png", [repeated("a"), alone])
    pixels = picture(tmp_path / "new" / "a.png")
    assert pixels.shape[:2] == (1020, 1425)
    for start in (0.0, 0.9):
        assert holds(pixels, mpl.colormaps["viridis"](start)) > 300
    # A cross stands in three panels of one group and in the legend.
    red = holds(pixels, (0.698, 0.094, 0.169))
    figure_robustness(tmp_path / "other" / "b.png", [repeated("a"), repeated("b")])
    assert red > 100 and holds(picture(tmp_path / "other" / "b.png"), (0.698, 0.094, 0.169)) > red


def test_a_field_is_drawn_around_the_truth(tmp_path: Path) -> None:
    left = NODES[FACES].mean(axis=1)[:, 0] < 0
    areas, some = np.ones(len(FACES)), NODES[::9]
    errors = np.linspace(0, 1, len(some))
    for name, high in (("apart", 1.5), ("alike", 1.0001)):
        ratio = np.where(left, high, 2 - high)
        one = TransferMap("ball", NODES, FACES, ratio, areas, (some, errors), (some, errors))
        figure_transfer(tmp_path / name / "a.png", [one, one])
    apart, alike = (picture(tmp_path / name / "a.png") for name in ("apart", "alike"))
    assert apart.shape[:2] == (1575, 1080)
    balls = slice(0, 400), slice(0, 400)
    assert hue_pixels(apart[balls]) > 20_000
    # A hundredth of a per cent is no pattern.
    assert hue_pixels(alike[balls]) < 200


def test_figures_leave_pyplot_alone(tmp_path: Path) -> None:
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    figure_history(tmp_path / "a.png", [2.0, 1.0])
    assert plt.get_fignums() == before


def test_an_older_figure_survives_an_error(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    with pytest.raises(IndexError):
        figure_field(path, NODES[:5], FACES, np.ones(len(FACES)), "t", "k [1]")
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]

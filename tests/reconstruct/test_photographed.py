"""The photographs that `benchmarks` judge reconstructions by, on balls of known size."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import trimesh

from thermo.imaging import pixel_centres, rays, read_cameras
from thermo.reconstruct import Picture, psnr, read_photographs

RADIUS = 0.02


@pytest.fixture(scope="module")
def photographed() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path(__file__).parents[2] / "benchmarks"))
        yield importlib.import_module("photographed")


def ball(radius: float = RADIUS) -> trimesh.Trimesh:
    found = trimesh.creation.icosphere(4, radius)
    found.apply_translation([0.3, -0.1, 0.2])
    return found


def test_a_ball_covers_the_disc_that_it_should_in_every_view(photographed: ModuleType) -> None:
    made = photographed.photographs_of(ball(), pixels=64)
    assert len(made.photographs) == 32
    assert len(made.left_out) == 4
    # The cone about the ball is cut by the plane of the picture in a disc of this radius.
    disc = np.pi * (0.5 * photographed.FILLED * 64) ** 2
    for one in (*made.photographs, *made.left_out):
        assert one.mask.sum() == pytest.approx(disc, rel=0.01)
        # Rays are means of 16, so that the rim is neither empty nor full.
        assert 100 < np.sum((one.mask > 0) & (one.mask < 1)) < 300
        middle = one.mask * np.indices(one.mask.shape)
        assert middle.sum(axis=(1, 2)) / one.mask.sum() == pytest.approx([31.5, 31.5], abs=0.05)


def test_a_pixel_shows_the_reflectance_and_light_of_its_place(photographed: ModuleType) -> None:
    truth = ball()
    camera = photographed.stood(truth, (40.0, 25.0), 65, "view")
    seen = photographed.photograph(truth, camera)
    lines = rays(camera, pixel_centres(camera))
    middle = truth.bounds.mean(axis=0)
    # The nearer point where |o + t d| = r.
    begin = camera.place() - middle
    half = lines @ begin
    inside = half**2 - begin @ begin + RADIUS**2
    well = np.flatnonzero(inside > 0.3 * RADIUS**2)
    points = begin + (-half[well] - np.sqrt(inside[well]))[:, None] * lines[well]
    size = np.linalg.norm(truth.extents)
    light = 0.7 + 0.3 * points[:, 2:] / RADIUS
    linear = photographed.reflectance(points / size) * light
    expected = 1.055 * linear ** (1 / 2.4) - 0.055
    apart = seen.colour.reshape(-1, 3)[well] - expected
    assert np.abs(apart).max() < 0.05
    assert np.sqrt((apart**2).mean()) < 0.01
    # Were it of one colour, none of this would say anything.
    assert seen.colour.reshape(-1, 3)[well].std(axis=0).min() > 0.05


def test_a_pixel_of_the_rim_has_the_colour_of_the_object(photographed: ModuleType) -> None:
    truth = ball()
    seen = photographed.photograph(truth, photographed.stood(truth, (40.0, 25.0), 64, "view"))
    rim = (seen.mask > 0) & (seen.mask < 0.3)
    assert seen.colour[rim].mean() > 0.8 * seen.colour[seen.mask == 1].mean()
    assert (seen.colour[seen.mask == 0] == 0).all()


def test_a_larger_ball_is_off_by_what_it_is_larger(photographed: ModuleType) -> None:
    error = photographed.surface_error(ball(1.02 * RADIUS), ball())
    assert error.distance == pytest.approx(0.02 * RADIUS, rel=0.02)
    assert error.share == pytest.approx(0.02 / (2 * np.sqrt(3)), rel=0.02)
    assert error.volume == pytest.approx(1.02**3, rel=1e-6)
    assert photographed.surface_error(ball(), ball()).distance < 1e-9


def test_what_is_missing_counts_from_the_true_surface(photographed: ModuleType) -> None:
    whole = trimesh.util.concatenate([ball(), ball().apply_translation([0.1, 0, 0])])
    error = photographed.surface_error(ball(), whole)
    # One way nothing is off; the other way half the points are about a tenth of a metre away.
    assert error.distance == pytest.approx(0.25 * (0.1 - RADIUS), rel=0.1)
    assert error.volume == pytest.approx(0.5, rel=1e-6)


def test_silhouettes_overlap_by_their_areas(photographed: ModuleType) -> None:
    seen = photographed.photograph(ball(), photographed.stood(ball(), (10.0, 20.0), 128, "view"))
    assert photographed.silhouette_iou(ball(), seen) > 0.99
    smaller = ball(0.9 * RADIUS)
    # Of a ball of radius r at distance d the disc has r^2 / (d^2 - r^2).
    share = 0.81 * (photographed.AWAY**2 - 1) / (photographed.AWAY**2 - 0.81)
    assert photographed.silhouette_iou(smaller, seen) == pytest.approx(share, abs=0.01)


def test_psnr_weighs_pixels_by_what_is_covered(photographed: ModuleType) -> None:
    seen = photographed.photograph(ball(), photographed.stood(ball(), (10.0, 20.0), 32, "view"))
    laid = seen.mask[..., None] * seen.colour

    def shown(colour: np.ndarray) -> Picture:
        return Picture(colour, seen.mask, seen.mask, laid)

    assert psnr(shown(laid + 0.1), seen) == pytest.approx(20.0)
    elsewhere = laid + 0.7 * (seen.mask == 0)[..., None] + 0.01
    assert psnr(shown(elsewhere), seen) == pytest.approx(40.0)


def test_a_folder_of_photographs_is_read_back(photographed: ModuleType, tmp_path: Path) -> None:
    truth = ball()
    made = tuple(
        photographed.photograph(truth, photographed.stood(truth, place, 24, f"view_{number:02d}"))
        for number, place in enumerate(photographed.LEFT_OUT[:3])
    )
    photographed.write_photographs(tmp_path, made)
    views = read_cameras(tmp_path / "transforms.json")
    found = read_photographs(views, tmp_path)
    for one, back in zip(made, found, strict=True):
        np.testing.assert_allclose(back.colour, one.colour, atol=1e-9)
        np.testing.assert_allclose(back.mask, one.mask, atol=1e-9)
        np.testing.assert_allclose(back.camera.pose, one.camera.pose, atol=1e-12)
        np.testing.assert_allclose(back.camera.centre, one.camera.centre, atol=1e-12)
        assert back.file.endswith(one.file)


def test_the_same_photographs_every_time(photographed: ModuleType) -> None:
    camera = photographed.stood(ball(), (10.0, 20.0), 24, "view")
    one, other = (photographed.photograph(ball(), camera) for _ in range(2))
    np.testing.assert_array_equal(one.colour, other.colour)

"""Objects before a dark ground."""

from __future__ import annotations

import numpy as np
import pytest
from coloured_ball import cameras

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at
from thermo.reconstruct import Photograph, masked_by_threshold, threshold_of

SIZE = 64
ROWS, COLUMNS = np.indices((SIZE, SIZE))
DISC = (ROWS - 30) ** 2 + (COLUMNS - 33) ** 2 < 18**2


def pictured(values: np.ndarray) -> Photograph:
    """Values of one channel as a blue picture."""
    pose = looking_at(np.array([0.0, 0, 1]), np.zeros(3), np.array([0.0, 1, 0]))
    camera = Camera(SIZE, SIZE, (50.0, 50.0), (31.5, 31.5), pose)
    return Photograph(camera, np.stack([0 * values, 0 * values, values], axis=2), None, "a.png")


def before_ground(seed: int, ground: float = 0.05, noise: float = 0.02) -> Photograph:
    """A disc, shaded from 0.35 to 0.95, before a noisy ground."""
    random = np.random.default_rng(seed)
    shade = 0.35 + 0.6 * COLUMNS / SIZE
    values = np.where(DISC, shade, ground) + noise * random.normal(size=(SIZE, SIZE))
    return pictured(np.clip(values, 0.0, 1.0))


def overlap(found: Photograph) -> float:
    assert found.mask is not None
    inside = found.mask > 0.5
    return float((inside & DISC).sum() / (inside | DISC).sum())


@pytest.mark.parametrize("ground", [0.0, 0.05, 0.15])
def test_the_threshold_lies_between_ground_and_object(ground: float) -> None:
    given = [before_ground(seed, ground) for seed in range(3)]
    level = threshold_of(given)
    assert ground + 2 * 0.02 < level < 0.5
    assert all(overlap(one) > 0.93 for one in masked_by_threshold(given, level))


def test_specks_are_left_out_and_pinholes_closed_but_openings_stay() -> None:
    values = np.where(DISC, 0.8, 0.0)
    values[2:5, 2:5] = 0.9  # a speck of the ground
    opening = (ROWS - 30) ** 2 + (COLUMNS - 33) ** 2 < 6**2
    values[opening] = 0.0
    (found,) = masked_by_threshold([pictured(values)], 0.4)
    assert found.mask is not None
    assert not found.mask[:8, :8].any()
    assert not found.mask[30, 33]
    assert found.mask[30, 33 + 12] == 1.0


def test_shadows_are_bridged_up_to_twice_the_reach_and_outlines_stay() -> None:
    values = np.where(DISC, 0.8, 0.0)
    values[28:32] = 0.0  # a shadow right across, 4 pixels wide
    (apart,) = masked_by_threshold([pictured(values)], 0.4)
    (whole,) = masked_by_threshold([pictured(values)], 0.4, bridged=3)
    assert overlap(apart) < 0.6 and overlap(whole) > 0.97
    (wide,) = masked_by_threshold(
        [pictured(np.where(abs(ROWS - 30) < 5, 0.0, values))], 0.4, bridged=3
    )
    assert overlap(wide) < 0.6, "nine pixels are more than twice three"
    with pytest.raises(InputError, match="gaps to close"):
        masked_by_threshold([pictured(values)], 0.4, bridged=-1)


@pytest.mark.parametrize("values", [np.zeros((SIZE, SIZE)), np.where(DISC, 0.1, 0.9)])
def test_without_a_dark_ground_it_says_so(values: np.ndarray) -> None:
    with pytest.raises(InputError, match="no dark ground") as caught:
        threshold_of([pictured(values)])
    assert "masks" in caught.value.remedy


@pytest.mark.parametrize("level", [0.0, 1.5])
def test_a_threshold_is_a_brightness(level: float) -> None:
    with pytest.raises(InputError):
        masked_by_threshold([before_ground(0)], level)


def test_pictures_are_of_their_camera() -> None:
    camera = cameras(1)[0]
    with pytest.raises(InputError, match="another size"):
        Photograph(camera, np.zeros((SIZE, SIZE, 3)), None, "b.png")

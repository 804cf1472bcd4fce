"""Pictures and masks as they lie in files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.support.coloured_ball import cameras, photograph

from thermo.errors import InputError
from thermo.imaging import View
from thermo.reconstruct import masked_by_threshold, read_photographs, threshold_of

SIZE = (32, 32)


def left(folder: Path, name: str, values: np.ndarray) -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.round(255 * values).astype(np.uint8)).save(path)


def views(name: str = "images/a.png") -> list[View]:
    return [View(cameras(1)[0], name)]


def test_colours_and_alpha_are_shares(tmp_path: Path) -> None:
    made = photograph(cameras(1)[0])
    assert made.mask is not None
    left(tmp_path, "images/a.png", np.dstack([made.colour, made.mask]))
    for folder, name in ((tmp_path, "images/a.png"), (tmp_path / "images", "./other/a")):
        found = read_photographs(views(name), folder)[0]
        np.testing.assert_allclose(found.colour, made.colour, atol=0.5 / 255 + 1e-9)
        np.testing.assert_allclose(found.mask, made.mask, atol=0.5 / 255 + 1e-9)


def test_an_alpha_channel_that_cuts_nothing_out_is_no_mask(tmp_path: Path) -> None:
    left(tmp_path, "images/a.png", np.ones((*SIZE, 4)))
    assert read_photographs(views(), tmp_path)[0].mask is None


@pytest.mark.parametrize("name", ["a.png", "a.png.png", "a.jpg"])
def test_masks_lie_in_a_folder_of_their_own(tmp_path: Path, name: str) -> None:
    left(tmp_path, "images/a.png", np.full((*SIZE, 3), 0.5))
    shape = np.zeros(SIZE)
    shape[8:20, 4:30] = 1.0
    left(tmp_path, f"masks/{name}", shape)
    found = read_photographs(views(), tmp_path, masks=tmp_path / "masks")[0]
    assert found.mask is not None
    np.testing.assert_array_equal(found.mask > 0.5, shape > 0.5)


def test_a_threshold_finds_what_is_bright_on_dark_ground(tmp_path: Path) -> None:
    made = photograph(cameras(1)[0])
    assert made.mask is not None
    random = np.random.default_rng(0)
    ground = made.colour * made.mask[..., None] + 0.02 * random.uniform(size=(*SIZE, 3))
    left(tmp_path, "images/a.png", np.clip(ground, 0, 1))
    plain = read_photographs(views(), tmp_path)
    assert plain[0].mask is None
    found = masked_by_threshold(plain, threshold_of(plain))[0]
    assert found.mask is not None
    both = ((found.mask > 0.5) & (made.mask > 0.5)).sum()
    assert both / ((found.mask > 0.5) | (made.mask > 0.5)).sum() > 0.85


def test_sixteen_bits_and_grey_are_read(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    Image.fromarray(np.full(SIZE, 32768, np.uint16)).save(tmp_path / "images" / "a.png")
    np.testing.assert_allclose(read_photographs(views(), tmp_path)[0].colour, 0.5, atol=1e-4)


def test_what_is_missing_broken_or_of_another_size_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="images/a.png"):
        read_photographs(views(), tmp_path)
    with pytest.raises(InputError, match="names no picture"):
        read_photographs(views(""), tmp_path)
    left(tmp_path, "images/a.png", np.ones((16, 32, 3)))
    with pytest.raises(InputError, match="another size"):
        read_photographs(views(), tmp_path)
    (tmp_path / "images" / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n no more")
    with pytest.raises(InputError, match="cannot be read"):
        read_photographs(views(), tmp_path)

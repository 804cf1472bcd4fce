"""Training on photographs of a coloured ball."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from coloured_ball import CENTRE, PIXELS, RADIUS, cameras, photograph

from thermo.errors import InputError
from thermo.imaging import pixel_centres, rays
from thermo.reconstruct import _picture, _train
from thermo.reconstruct._objective import Parts
from thermo.reconstruct._photograph import Photograph
from thermo.reconstruct._picture import picture
from thermo.reconstruct._region import Region
from thermo.reconstruct._render_rays import Sampling
from thermo.reconstruct._train import Trained, distance_of, train
from thermo.reconstruct._training import Training

# Neither in the middle of the region nor as large as the ball that training begins with.
REGION = Region(CENTRE + [0.004, 0.0, -0.003], 0.04)
SMALL = Training(
    steps=300, rays=192, cells=(8, 16), width=32, rate=1e-2, sampling=Sampling(16, 1, 16)
)
BRIEF = Training(
    steps=100, rays=32, cells=(4,), width=8, told=3, warm=10, sampling=Sampling(8, 1, 8)
)


@pytest.fixture(scope="module", autouse=True)
def small_pictures() -> Iterator[None]:
    """As many rays are rendered at a time as these pictures have, and none in vain."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_picture, "_RAYS", PIXELS**2)
        yield


@pytest.fixture(scope="module")
def photographs() -> list[Photograph]:
    return [photograph(camera) for camera in cameras(12)]


@pytest.fixture(scope="module")
def trained(photographs: list[Photograph]) -> Trained:
    return train(photographs, REGION, SMALL)


Told = list[tuple[int, int, float]]


@pytest.fixture(scope="module")
def left(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the short training leaves its checkpoint."""
    return tmp_path_factory.mktemp("brief") / "checkpoint.npz"


@pytest.fixture(scope="module")
def brief(photographs: list[Photograph], left: Path) -> tuple[Trained, Told]:
    """A short training, and what it told of itself."""
    said: Told = []
    found = train(
        photographs, REGION, BRIEF, checkpoint=left, on_step=lambda *one: said.append(one)
    )
    return found, said


def leaves(trained: Trained) -> list[np.ndarray]:
    return [np.asarray(one) for one in jax.tree.leaves(eqx.filter(trained.surface, eqx.is_array))]


def test_the_ball_comes_out_where_it_is_and_as_large(trained: Trained) -> None:
    rng = np.random.default_rng(0)
    way = rng.normal(size=(500, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    on = (CENTRE + RADIUS * way - REGION.centre) / REGION.half
    off = np.asarray(distance_of(trained)(jax.numpy.asarray(on))) * REGION.half
    # The box's diagonal is 104 mm, of which the bar is 0.7 per cent.
    assert np.abs(off).mean() < 0.003 * np.sqrt(12) * RADIUS
    assert abs(off.mean()) < 0.02 * RADIUS / 3, "two per cent of volume"


def test_a_view_that_was_left_out_is_predicted(trained: Trained) -> None:
    other = photograph(cameras(1, turn=0.7)[0])
    shown = picture(trained, other.camera)
    inside = other.mask > 0.99
    square = float(((shown.colour - other.colour)[inside] ** 2).mean())
    assert -10 * np.log10(square) > 30
    assert np.abs(shown.covered - other.mask).mean() < 0.01
    # In the middle the ball is a radius nearer than its centre.
    middle = shown.depth[15:17, 15:17].mean()
    assert middle == pytest.approx(0.2 - RADIUS, abs=0.001)
    toward = (other.camera.place() - CENTRE) / 0.2
    assert (shown.normal[15:17, 15:17] @ toward > 0.97).all()
    assert np.isnan(shown.depth[0, 0]) and shown.covered[0, 0] < 0.01


def test_progress_and_the_record_speak_of_every_step(brief: tuple[Trained, Told]) -> None:
    found, said = brief
    assert [one[0] for one in said] == [50, 100] and {one[1] for one in said} == {100}
    assert found.psnr.shape == (100,)
    assert said[-1][2] == pytest.approx(found.psnr[-50:].mean())


def test_the_last_loop_makes_the_steps_that_are_left(
    photographs: list[Photograph], monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []

    def noted(state: _train.State, *rest: Any) -> tuple[_train.State, Parts]:
        """Nothing is learned, and no loop of another length compiled."""
        numbers = np.asarray(rest[2])
        made.extend(numbers)
        return state, Parts(*[0.1 ** (1 + jnp.asarray(numbers) / 100)] * len(Parts._fields))

    monkeypatch.setattr(_train, "_steps", noted)
    said: Told = []
    odd = dataclasses.replace(BRIEF, steps=120)
    found = train(photographs, REGION, odd, on_step=lambda *one: said.append(one))
    assert made == list(range(120))
    assert [one[:2] for one in said] == [(50, 120), (100, 120), (120, 120)]
    np.testing.assert_allclose(found.psnr, 10 + np.arange(120) / 10)
    assert said[-1][2] == pytest.approx(found.psnr[-20:].mean())


def test_after_an_interruption_it_goes_on_as_if_nothing_had_been(
    photographs: list[Photograph], brief: tuple[Trained, Told], tmp_path: Path
) -> None:
    file = tmp_path / "checkpoint.npz"
    whole, _ = brief

    def stop(made: int, *_: object) -> None:
        if made == 50:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(photographs, REGION, BRIEF, checkpoint=file, on_step=stop)
    again: list[int] = []
    resumed = train(
        photographs, REGION, BRIEF, checkpoint=file, on_step=lambda made, *_: again.append(made)
    )
    assert again == [100], "what had been done is not done again"
    assert all(np.array_equal(a, b) for a, b in zip(leaves(whole), leaves(resumed), strict=True))
    assert np.array_equal(whole.psnr, resumed.psnr)


def test_a_checkpoint_of_another_training_is_refused(
    photographs: list[Photograph], brief: tuple[Trained, Told], left: Path
) -> None:
    assert len(brief[0].psnr) == BRIEF.steps and left.exists()
    other = dataclasses.replace(BRIEF, seed=1)
    with pytest.raises(InputError, match="another training"):
        train(photographs, REGION, other, checkpoint=left)
    with pytest.raises(InputError, match="another training"):
        train(photographs[1:], REGION, BRIEF, checkpoint=left)


def test_masks_are_known_of_all_or_of_none(photographs: list[Photograph]) -> None:
    bare = eqx.tree_at(lambda one: one.mask, photographs[3], None)
    with pytest.raises(InputError, match="others none") as caught:
        train([*photographs[:3], bare], REGION, BRIEF)
    assert caught.value.where == "view3.png"


def test_a_region_that_no_camera_sees_is_refused(photographs: list[Photograph]) -> None:
    away = Region(CENTRE + [0.0, 0.0, 9.0], 0.01)
    with pytest.raises(InputError, match="looks into the region"):
        train(photographs, away, BRIEF)


def test_without_masks_the_object_is_told_from_what_stands_behind(
    photographs: list[Photograph],
) -> None:
    before = [before_far_walls(one) for one in photographs]
    found = train(before, REGION, SMALL)
    other = photograph(cameras(1, turn=0.7)[0])
    shown = picture(found, other.camera)
    inside = shown.covered > 0.5
    both = (inside & (other.mask > 0.5)).sum() / (inside | (other.mask > 0.5)).sum()
    assert both > 0.9


def before_far_walls(photograph: Photograph) -> Photograph:
    """The same before bands of colour that are infinitely far away, without a mask."""
    camera = photograph.camera
    sight = rays(camera, pixel_centres(camera)).reshape(*photograph.mask.shape, 3)
    walls = 0.5 + 0.4 * np.sin(9.0 * sight[..., [2, 0, 1]])
    share = photograph.mask[..., None]
    colour = share * photograph.colour + (1 - share) * walls
    return Photograph(camera, colour, None, photograph.file)

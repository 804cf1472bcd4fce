"""Parts of a misfit add up to the whole, and noise alone leaves one for each."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.discover._misfit import chance_near, misfits
from thermo.discover._modes import space_modes, time_modes
from thermo.discover._softening import Block

FRAMES, SAMPLES = 40, 30


def blocks() -> list[Block]:
    """Two runs, the second of which lacks its last frames."""
    found = []
    for number, name in enumerate(("lamp", "cooling")):
        points = np.random.default_rng(number).uniform(0, 0.02, (SAMPLES, 3))
        count = FRAMES * SAMPLES
        part = slice(number * count, (number + 1) * count)
        modes = time_modes(FRAMES), space_modes(points)
        read = count - 5 * SAMPLES * number
        found.append(Block(name, part, (FRAMES, SAMPLES), *modes, 0.0, 1.05, read))
    return found


def test_the_parts_add_up_and_noise_leaves_one_for_each() -> None:
    runs, random = blocks(), np.random.default_rng(5)
    drawn = [random.standard_normal(2 * FRAMES * SAMPLES) for _ in range(40)]
    for residual in drawn:
        residual[-5 * SAMPLES :] = 0.0
    every = [misfits(runs, residual) for residual in drawn]
    for found, residual in zip(every, drawn, strict=True):
        parts = [(m.steady, m.changing, m.rest) for m in found.values()]
        assert sum(p.squares for m in parts for p in m) == pytest.approx(residual @ residual)
        assert sum(p.expected for m in parts for p in m) == np.count_nonzero(residual)
    for kind in ("steady", "changing", "rest"):
        mean = np.mean([getattr(found["lamp"], kind).squares for found in every])
        assert mean == pytest.approx(getattr(every[0]["lamp"], kind).expected, rel=0.15)


def test_what_does_not_change_is_steady_and_what_grows_is_not() -> None:
    runs = blocks()
    (lamp, _) = runs
    shape = lamp.in_space[:, :1].T
    still = np.concatenate([np.repeat(shape, FRAMES, 0).ravel(), np.zeros(FRAMES * SAMPLES)])
    found = misfits(runs, still)["lamp"]
    assert found.steady.squares == pytest.approx(still @ still)
    assert abs(found.changing.squares) + abs(found.rest.squares) < 1e-9
    growing = still.reshape(2, FRAMES, SAMPLES) * np.linspace(-1, 1, FRAMES)[:, None]
    found = misfits(runs, growing.ravel())["lamp"]
    assert found.changing.squares > 0.9 * float((growing**2).sum())
    assert found.steady.squares < 1e-9


def test_noise_at_a_few_samples_is_by_chance_and_what_is_slow_there_is_not() -> None:
    runs, random = blocks(), np.random.default_rng(6)
    near = {"lamp": np.arange(SAMPLES) < 4, "cooling": np.arange(SAMPLES) == 7}
    drawn = [random.standard_normal(2 * FRAMES * SAMPLES) for _ in range(400)]
    chances = np.array([chance_near(runs, one, near) for one in drawn])
    # Noise is taken for as large as it may be, so that fewer than one in ten are below a tenth.
    assert 0.01 < np.mean(chances < 0.1) < 0.1
    slow = np.zeros((2, FRAMES, SAMPLES))
    for sample, less in ((2, True), (9, False)):
        slow[:] = 0.0
        slow[0, :, sample] = 3.0 * np.linspace(-1, 1, FRAMES)
        assert (chance_near(runs, drawn[0] + slow.ravel(), near) < 0.01) == less
    nowhere = {name: np.zeros(SAMPLES, bool) for name in near}
    assert chance_near(runs, drawn[0], nowhere) == 1.0

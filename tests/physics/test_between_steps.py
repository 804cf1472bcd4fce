"""Temperatures between steps."""

from __future__ import annotations

import numpy as np

from thermo.physics import between_steps

TIME = np.linspace(0.0, 4.0, 17) ** 2 / 4


def test_order_of_four() -> None:
    errors = []
    frames = np.linspace(0, 4, 301)
    for count in (20, 40):
        time = np.linspace(0, 4, count + 1)
        values = np.stack([np.sin(time), np.exp(-time)], axis=1)
        exact = np.stack([np.sin(frames), np.exp(-frames)], axis=1)
        errors.append(np.abs(between_steps(time, values, frames) - exact).max())
    assert np.log2(errors[0] / errors[1]) > 3.5


def test_a_switch_is_not_smoothed_over() -> None:
    switch = TIME[8]
    values = np.maximum(TIME - switch, 0.0)[:, None]
    frames = np.linspace(0, 4, 101)
    heeded = between_steps(TIME, values, frames, [switch])
    np.testing.assert_allclose(heeded[:, 0], np.maximum(frames - switch, 0), atol=1e-12)
    assert np.abs(between_steps(TIME, values, frames) - heeded).max() > 1e-3


def test_ends_of_steps_are_kept() -> None:
    values = np.random.default_rng(0).standard_normal((len(TIME), 3))
    np.testing.assert_allclose(between_steps(TIME, values, TIME), values, atol=1e-12)

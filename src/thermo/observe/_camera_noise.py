"""Noise of a thermal camera, put on a recording without noise."""

from __future__ import annotations

import numpy as np

from thermo.errors import InputError

from ._recording import Recording


def with_camera_noise(
    recording: Recording,
    initial_temperature: float,
    *,
    white: float = 0.05,
    pattern: float = 0.03,
    quiet: int = 25,
    seed: int = 0,
) -> Recording:
    """The recording as a camera would have read it.

    Each reading gets independent noise, each sample an error of its own that stays, and frames of
    the body at rest before the run show both, as people record them to know their camera.

    Arguments:

    - `recording`: temperatures [K]; `initial_temperature`: of the body before the run [K].
    - `white`: standard deviation of the noise of a reading [K]; `pattern`: of what stays [K].
    - `quiet`: number of frames before the run [1], none for 0; `seed`: of all random numbers.

    Raises `InputError` where a level is negative or not finite.
    """
    for name, level in (("white", white), ("pattern", pattern), ("quiet", quiet)):
        if not (np.isfinite(level) and level >= 0):
            raise InputError(
                "a camera has no such noise", where=name, value=level,
                limit="a finite number, 0 or more", remedy=f"leave {name} at its default",
            )  # fmt: skip
    random = np.random.default_rng(seed)
    frames, samples = recording.temperature.shape
    fixed = pattern * random.standard_normal(samples)
    values = recording.temperature + white * random.standard_normal((frames, samples)) + fixed
    before = initial_temperature + white * random.standard_normal((quiet, samples)) + fixed
    return Recording(
        recording.points, recording.time, values, recording.valid, before if quiet else None
    )

"""What each sample reads wrong all the time, where a run states how large that may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import FRAMES, POINTS, run

from thermo.inverse import left_open, staying
from thermo.observe import Noise, Recording, Run, estimate_noise

SHAPE = (len(FRAMES), len(POINTS))


def test_nothing_is_taken_off_where_nothing_is_stated() -> None:
    np.testing.assert_array_equal(staying(np.ones(SHAPE), run()), 0.0)


@given(st.floats(0.01, 3.0), st.integers(0, 10**6))
def test_it_is_the_mean_drawn_to_zero_by_what_is_stated(stated: float, seed: int) -> None:
    one = replace(run(), constant_error=stated)
    apart = np.random.default_rng(seed).normal(size=SHAPE)
    apart[2, 1] = np.nan
    white = estimate_noise(one.recording).white
    count = np.isfinite(apart).sum(0)
    share = stated**2 / (stated**2 + white**2 / count)
    np.testing.assert_allclose(staying(apart, one), share * np.nanmean(apart, 0))


def test_what_the_noise_has_of_it_counts_where_it_is_more_than_what_is_stated() -> None:
    apart = np.random.default_rng(2).normal(size=SHAPE)
    learnt = replace(run(), noise=Noise(0.05, 0.4))
    like = replace(run(), constant_error=0.4, noise=Noise(0.05, 0.0))
    np.testing.assert_array_equal(staying(apart, learnt), staying(apart, like))
    assert np.any(staying(apart, learnt))
    more = replace(learnt, constant_error=2.0)
    assert np.all(np.abs(staying(apart, more)) > np.abs(staying(apart, learnt)))
    # Quiet frames have told it, and it has been taken off.
    quiet = replace(run(quiet=True), noise=Noise(0.05, 0.4))
    np.testing.assert_array_equal(staying(apart, quiet), 0.0)


def test_a_sample_that_reads_nothing_has_none() -> None:
    apart = np.ones(SHAPE)
    apart[:, 2] = np.nan
    found = staying(apart, replace(run(), constant_error=20.0))
    assert found[2] == 0.0 and found[0] == pytest.approx(1.0, rel=1e-6)


def test_means_of_quiet_frames_leave_open_what_they_scatter_by() -> None:
    random = np.random.default_rng(1)
    # What whole frames are off by stays in the means of twelve quiet frames as well.
    own, whole = 0.05 * random.standard_normal((12, 900)), 0.2 * random.standard_normal((12, 1))
    points, time = random.uniform(0.0, 0.02, (900, 3)), np.linspace(0.0, 1.0, 3)
    record = Recording(points, time, np.full((3, 900), 300.0), quiet=300.0 + own + whole)
    found = left_open(Run("dark", record, 300.0, 300.0, 300.0))
    noise = estimate_noise(record)
    np.testing.assert_allclose(found, (noise.long_run() ** 2 + noise.frame**2) / 12)
    assert np.sqrt(found.mean()) == pytest.approx(np.std(whole) / np.sqrt(12), rel=0.2)
    blind = Recording(points, time, np.full((3, 900), 300.0))
    assert not left_open(Run("dark", blind, 300.0, 300.0, 300.0)).any()

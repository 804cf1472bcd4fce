"""How much of a gap is closed on readings that were not fitted, and how sure that is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import MESH, STATED
from scipy.signal import lfilter

from thermo.discover import _held_out
from thermo.discover._bench import Apart, Bench
from thermo.discover._extended import Extended
from thermo.discover._held_out import _compared, closed, closed_interval, held_out
from thermo.discover.candidates import TemperatureDependentConductivity
from thermo.errors import InputError
from thermo.inverse import coarse_tangents, lay_out
from thermo.observe import Recording, Run

from .lit_objective import box_task

FRAMES = 50.0


def squares(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return np.stack([before, after, np.full(len(before), FRAMES)])


@given(st.floats(0.0, 1.0), st.integers(10, 60))
def test_where_samples_are_alike_the_share_is_sure(share: float, samples: int) -> None:
    made = squares(np.full(samples, 10 * FRAMES), np.full(samples, FRAMES * (10 - 9 * share)))
    assert float(closed(made.sum(1))) == pytest.approx(share, abs=1e-9)
    assert closed_interval(made, 0.0) == pytest.approx((share, share), abs=1e-9)


def test_of_many_drawn_bodies_the_interval_holds_the_true_share_as_often_as_it_says() -> None:
    random, inside = np.random.default_rng(0), 0
    for _ in range(300):
        gap = random.exponential(200.0, 80)
        rest = gap * random.uniform(0, 0.4, 80)
        ends = closed_interval(squares(FRAMES + gap, FRAMES + rest), 0.0)
        assert ends is not None
        inside += ends[0] <= 0.8 <= ends[1]
    # Of 300 at 95 % fewer than 270 come once in ten thousand.
    assert inside >= 270


def test_few_samples_tell_no_interval() -> None:
    assert closed_interval(squares(np.full(9, 500.0), np.full(9, 60.0)), 0.1) is None


@given(st.floats(0.01, 0.2))
def test_noise_that_is_not_well_known_widens_the_interval(doubt: float) -> None:
    # Of 10 units 9 are a gap, and a tenth of noise more leaves a tenth less of what is left.
    made = squares(np.full(80, 10 * FRAMES), np.full(80, 1.9 * FRAMES))
    ends = closed_interval(made, doubt)
    assert ends is not None
    low, high = (1 - (0.9 - 1.96 * way * doubt) / (9 - 1.96 * way * doubt) for way in (-1, 1))
    assert ends == pytest.approx((low, high), abs=0.03 * doubt)


def test_readings_that_follow_each_other_are_as_much_noise_as_they_are() -> None:
    random, size = np.random.default_rng(3), 0.05
    points = np.stack(
        [random.uniform(0.002, 0.018, 24), random.uniform(0.002, 0.01, 24), np.full(24, 0.008)], 1
    )
    fresh = random.standard_normal((360, 24)) * size * np.sqrt(1 - 0.6**2)
    noise = lfilter([1.0], [1.0, -0.6], fresh, axis=0)[60:]
    time = np.linspace(0.0, 24.0, 200)
    record = Recording(points, time, 300.0 + noise[100:], quiet=300.0 + noise[:100])
    one = Run("dark", record, 300.0, 300.0, 300.0)
    # A difference that grows, of which a half in the mean square is left.
    gap = 0.09 * np.sqrt(3.0) * np.linspace(0.0, 1.0, 200)[:, None] * np.ones(24)
    before, after = (noise[100:] + part * gap for part in (1.0, np.sqrt(0.5)))
    found = _compared((before, after), one, time)
    assert found.gap_closed == pytest.approx(0.5, abs=0.05)
    # Weighed as readings that follow each other are, a slow difference is little beside noise whose
    # size is known to 13 %, and all of it might have been closed.
    assert found.doubt == pytest.approx(0.13, abs=0.01) and found.interval95 is not None
    assert 0.4 < found.interval95[0] < 0.5 < found.interval95[1] < 0.6
    alike = _compared((noise[100:], noise[100:]), one, time)
    assert alike.gap_closed is None, "nothing to close"


def test_noise_is_what_a_model_that_is_right_leaves() -> None:
    random, size = np.random.default_rng(5), 0.05
    points = random.uniform(0.0, 0.02, (400, 3))
    errors = 0.3 * random.standard_normal(400)
    read = 300.0 + errors + size * random.standard_normal((90, 400))
    time = np.linspace(0.0, 8.0, 80)
    # Ten quiet frames leave a tenth of a reading's variance of each sample's constant error.
    run = Run("dark", Recording(points, time, read[10:], quiet=read[:10]), 300.0, 300.0, 300.0)
    apart = read[10:] - read[:10].mean(0)
    found = _compared((apart, apart), run, time)
    assert found.noise == pytest.approx(size * np.sqrt(1.1), rel=0.02)
    assert found.rms_after == pytest.approx(found.noise, rel=0.02)
    assert found.gap_closed is None


def test_without_quiet_frames_noise_is_what_is_left_between_neighbours() -> None:
    random, size = np.random.default_rng(7), 0.05
    points, time = random.uniform(0.0, 0.02, (300, 3)), np.linspace(0.0, 8.0, 80)
    off = 0.4 * random.standard_normal(300)
    read = 300.0 + off + size * random.standard_normal((80, 300))
    run = Run("dark", Recording(points, time, read), 300.0, 300.0, 300.0)
    gap = 0.3 * np.sin(2.0 * time)[:, None]
    found = _compared((read - 300.0 + gap, read - 300.0), run, time)
    assert found.rms_after == pytest.approx(size, rel=0.03)
    assert found.noise == pytest.approx(size, rel=0.05)
    assert found.rms_before == pytest.approx(np.sqrt(np.mean(gap**2) + size**2), rel=0.03)
    assert found.gap_closed == pytest.approx(1.0, abs=0.02)


def test_infinitely_much_is_left_where_a_law_leads_to_temperatures_that_there_cannot_be(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    task = box_task(tmp_path)
    cold, hot = task.runs
    apart = {one.name: one for one in (cold, replace(hot, held_out=True))}
    task = replace(task, runs=(cold,), scene=replace(task.scene, runs=apart))
    ready = lay_out(task, MESH, STATED)
    bench = Bench(task, ready, coarse_tangents(task, ready), MESH)
    law = TemperatureDependentConductivity(jnp.zeros(1), None)
    stated = bench.first((law,))
    burst = replace(stated, candidates=(replace(law, strength=jnp.asarray([-0.05])),))

    def read(there: Bench, point: Extended) -> Apart:
        (case,) = there.coarse.cases
        if point is burst:
            raise InputError("cannot be", where="hot", value="-9 K", limit="0 K", remedy="units")
        return [case.data + 2.0]

    monkeypatch.setattr(_held_out, "finer_runs", read)
    found = held_out(bench, stated, burst)[hot.name]
    assert found.rms_after == np.inf and 0 < found.rms_before < np.inf
    assert np.array_equal(found.differences.before, found.differences.after, equal_nan=True)
    assert held_out(bench, stated, stated)[hot.name].rms_after == found.rms_before
    # Where what is stated does, its numbers are wrong.
    with pytest.raises(InputError, match="cannot be"):
        held_out(bench, burst, burst)

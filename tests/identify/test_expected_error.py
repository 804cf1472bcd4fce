"""Expected errors: closed forms, repeated fits of made-up data, and what no run shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.identify import expected_errors
from thermo.inverse import Sensitivity

FRAMES, SAMPLES = 40, 30


def slopes(seed: int, unknowns: int = 1) -> np.ndarray:
    """Slopes that grow over time, as temperatures do [K]."""
    grow = np.linspace(0, 1, FRAMES)[:, None, None]
    return grow * np.random.default_rng(seed).uniform(0.2, 1.0, (1, SAMPLES, unknowns))


def at(one: np.ndarray, noise: float = 0.05) -> Sensitivity:
    return Sensitivity(tuple("abc"[: one.shape[-1]]), {"run": one}, {"run": noise})


def test_white_noise_alone_has_its_closed_form() -> None:
    one = slopes(0)
    (found,) = expected_errors(at(one), model_error=1e-12)
    assert found.relative == pytest.approx(0.05 / np.linalg.norm(one), rel=1e-6)
    assert found.response == pytest.approx(np.sqrt(np.mean(one**2)), rel=1e-12)


def test_repeated_fits_scatter_as_expected() -> None:
    random, noise, model = np.random.default_rng(0), 0.05, 0.03
    one, two = slopes(1, 2), 2 * slopes(2, 2)
    both = Sensitivity(("a", "b"), {"x": one, "y": two}, {"x": noise, "y": 2 * noise})
    expected = [item.relative for item in expected_errors(both, model_error=model)]

    rows, errors = [], []
    for slope, white in ((one, noise), (two, 2 * noise)):
        weight = 1 / np.hypot(white, model)
        pattern = model * random.standard_normal((4000, 1, SAMPLES))
        error = white * random.standard_normal((4000, FRAMES, SAMPLES)) + pattern
        rows.append(slope.reshape(-1, 2) * weight)
        errors.append(error.reshape(4000, -1) * weight)
    fits = np.concatenate(errors, axis=1) @ np.linalg.pinv(np.concatenate(rows)).T
    # 4000 fits know a standard deviation to 1.1 %.
    assert np.std(fits, axis=0) == pytest.approx(expected, rel=0.05)


def test_what_samples_have_in_common_does_not_average_out_over_them() -> None:
    random, noise, frame, lasting = np.random.default_rng(3), 0.05, 0.04, 0.02
    one = slopes(1, 2)
    common = {"run": (frame, lasting)}
    (a, b) = expected_errors(replace(at(one, noise), common=common), model_error=1e-9)
    error = noise * random.standard_normal((4000, FRAMES, SAMPLES))
    error += frame * random.standard_normal((4000, FRAMES, 1))
    error += lasting * random.standard_normal((4000, 1, 1))
    fits = error.reshape(4000, -1) @ np.linalg.pinv(one.reshape(-1, 2)).T
    assert np.std(fits, axis=0) == pytest.approx([a.relative, b.relative], rel=0.05)


def test_what_no_run_shows_is_not_known() -> None:
    one = slopes(0, 3)
    one[..., 1] = 0.0
    first, second, third = expected_errors(at(one))
    assert np.isfinite([first.relative, third.relative]).all()
    assert second.relative == np.inf and second.response == 0.0 and not second.informed(0.5)


def test_two_unknowns_that_do_the_same_are_both_unknown() -> None:
    one = slopes(0, 3)
    one[..., 2] = -2 * one[..., 0]
    first, second, third = expected_errors(at(one))
    assert first.relative == third.relative == np.inf and np.isfinite(second.relative)


@given(factor=st.floats(0.1, 10.0), seed=st.integers(0, 99))
@settings(max_examples=25, deadline=None)
def test_the_error_falls_as_the_signal_grows(factor: float, seed: int) -> None:
    one = slopes(seed, 2)
    before, after = expected_errors(at(one)), expected_errors(at(factor * one))
    for old, new in zip(before, after, strict=True):
        assert new.relative == pytest.approx(old.relative / factor, rel=1e-6)


@pytest.mark.parametrize("wrong", [-0.01, float("nan"), float("inf")])
def test_a_model_error_that_cannot_be_is_refused(wrong: float) -> None:
    with pytest.raises(InputError, match="cannot be this"):
        expected_errors(at(slopes(0)), model_error=wrong)


def test_informed_is_a_95_percent_statement() -> None:
    (found,) = expected_errors(at(slopes(0)))
    assert found.informed(2.0 * found.relative) and not found.informed(1.9 * found.relative)

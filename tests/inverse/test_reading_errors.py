"""Whitening against the Cholesky factor of the covariance that it stands for."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from thermo.inverse import _reading_errors
from thermo.inverse._reading_errors import ReadingErrors, in_common, with_again, without

# As within a program: a loop by itself is compiled at every call.
whiten, colour = map(eqx.filter_jit, (_reading_errors.whiten, _reading_errors.colour))

FRAMES, SAMPLES = 7, 4


@st.composite
def kinds(draw: st.DrawFn) -> tuple[ReadingErrors, np.ndarray, int]:
    """Errors of each kind, none of some, and readings that are missing."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    fading, staying = draw(st.sampled_from([0.0, 0.3])), draw(st.sampled_from([0.0, 0.7]))
    kept = random.uniform(0, 0.95, FRAMES)
    errors = ReadingErrors(
        own=jnp.asarray(random.uniform(0.01, 1.0, (FRAMES, SAMPLES))),
        fading=jnp.asarray(fading),
        kept=jnp.asarray(kept),
        staying=jnp.asarray(staying * random.uniform(0, 1, SAMPLES)),
    )
    missing = draw(st.sampled_from([0.0, 0.3]))
    used = (random.uniform(size=(FRAMES, SAMPLES)) >= missing).astype(float)
    return errors, used, draw(st.integers(0, 1000))


def covariance(errors: ReadingErrors, sample: int) -> np.ndarray:
    """Of the errors of a sample's readings [K2], frame by frame."""
    steps = np.log(np.maximum(np.asarray(errors.kept), 1e-300)).cumsum()
    fades = np.exp(-np.abs(steps[:, None] - steps[None, :]))
    fades = float(errors.fading) * fades
    return np.diag(np.asarray(errors.own)[:, sample]) + fades + float(errors.staying[sample])


@given(kinds())
@settings(max_examples=25, deadline=None)
def test_whitening_is_the_inverse_of_the_cholesky_factor(
    kind: tuple[ReadingErrors, np.ndarray, int],
) -> None:
    errors, used, seed = kind
    apart = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES))
    white = np.asarray(whiten(errors, jnp.asarray(used), jnp.asarray(apart)))
    assert np.all(white[used == 0] == 0)
    for sample in range(SAMPLES):
        has = used[:, sample] > 0
        factor = np.linalg.cholesky(covariance(errors, sample)[np.ix_(has, has)])
        wanted = np.linalg.solve(factor, apart[has, sample])
        np.testing.assert_allclose(white[has, sample], wanted, rtol=1e-8, atol=1e-10)


@given(kinds())
@settings(max_examples=25, deadline=None)
def test_colouring_undoes_it(kind: tuple[ReadingErrors, np.ndarray, int]) -> None:
    errors, used, seed = kind
    white = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES))
    apart = colour(errors, jnp.asarray(used), jnp.asarray(white))
    again = whiten(errors, jnp.asarray(used), apart)
    np.testing.assert_allclose(again, white * used, rtol=1e-9, atol=1e-9)


@given(kinds(), st.sampled_from([0.0, 0.4]), st.sampled_from([0.0, 0.2]))
@settings(max_examples=15, deadline=None)
def test_what_samples_have_in_common_is_whitened_as_the_whole_covariance_asks(
    kind: tuple[ReadingErrors, np.ndarray, int], frame: float, lasting: float
) -> None:
    alone, used, seed = kind
    errors = in_common(alone, jnp.asarray(used), jnp.asarray(frame), jnp.asarray(lasting))
    apart = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES)) * used
    # Of samples one after the other, each with all its frames.
    whole = block_diag(*(covariance(alone, sample) for sample in range(SAMPLES)))
    whole += np.tile(frame**2 * np.eye(FRAMES) + lasting**2, (SAMPLES, SAMPLES))
    has = used.T.ravel() > 0
    wanted = apart.T.ravel()[has] @ np.linalg.solve(whole[np.ix_(has, has)], apart.T.ravel()[has])
    white = whiten(errors, jnp.asarray(used), jnp.asarray(apart))
    assert float(jnp.sum(white**2)) == pytest.approx(wanted, rel=1e-8)
    back = np.asarray(colour(errors, jnp.asarray(used), white)) * used
    np.testing.assert_allclose(back, apart, atol=1e-8)
    extra = np.asarray(errors.variance() - alone.variance())
    np.testing.assert_allclose(extra, frame**2 + lasting**2, rtol=1e-12)


def test_what_a_missing_reading_would_be_is_foretold_by_the_others() -> None:
    errors = ReadingErrors(
        own=jnp.full((3, 1), 1e-12), fading=jnp.asarray(1.0),
        kept=jnp.asarray([0.0, 0.5, 0.5]), staying=jnp.zeros(1),
    )  # fmt: skip
    used = jnp.asarray([[1.0], [0.0], [0.0]])
    found = np.asarray(colour(errors, used, jnp.asarray([[2.0], [5.0], [5.0]])))
    np.testing.assert_allclose(found[:, 0], [2.0, 1.0, 0.5], rtol=1e-6)


def test_a_tangent_is_whitened_as_a_difference_is() -> None:
    random = np.random.default_rng(0)
    errors = ReadingErrors(
        own=jnp.full((FRAMES, SAMPLES), 0.2), fading=jnp.asarray(0.5),
        kept=jnp.full(FRAMES, 0.6), staying=jnp.full(SAMPLES, 0.3),
    )  # fmt: skip
    used = jnp.ones((FRAMES, SAMPLES))
    first, way = jnp.asarray(random.standard_normal((2, FRAMES, SAMPLES)))
    for one in (errors, in_common(errors, used, jnp.asarray(0.4), jnp.asarray(0.2))):

        def white(apart: jax.Array, one: ReadingErrors = one) -> jax.Array:
            return whiten(one, used, apart)

        _, tangent = jax.jvp(white, (first,), (way,))
        np.testing.assert_allclose(tangent, white(way), rtol=1e-10, atol=1e-12)
        _, pull = jax.vjp(white, first)
        assert jnp.vdot(pull(first)[0], way) == pytest.approx(float(jnp.vdot(first, tangent)))
    assert errors.variance().shape == (FRAMES, SAMPLES)
    np.testing.assert_allclose(errors.variance(), 1.0)


def test_a_shared_error_is_taken_out_as_its_covariance_asks() -> None:
    random = np.random.default_rng(1)
    shared, white = random.standard_normal((2, FRAMES, SAMPLES))
    column = shared.ravel()
    size, way = np.linalg.eigh(np.eye(column.size) + np.outer(column, column))
    root = (way / np.sqrt(size)) @ way.T
    freed = without(jnp.asarray(shared), jnp.asarray(white))
    np.testing.assert_allclose(freed, (root @ white.ravel()).reshape(white.shape), atol=1e-12)
    again = with_again(jnp.asarray(shared), freed)
    np.testing.assert_allclose(again, white, rtol=1e-10, atol=1e-12)
    # However large it is, it says no more than a part of itself.
    huge = without(jnp.asarray(1e6 * shared), jnp.asarray(1e6 * shared))
    assert float(jnp.linalg.norm(huge)) < 1.001


def test_nothing_shared_changes_nothing() -> None:
    white = jnp.asarray(np.random.default_rng(2).standard_normal((FRAMES, SAMPLES)))
    none = jnp.zeros((FRAMES, SAMPLES))
    assert np.array_equal(without(none, white), white)
    assert np.array_equal(with_again(none, white), white)
    slope = jax.grad(lambda one: jnp.sum(without(one, white) ** 2))(none)
    assert np.all(np.isfinite(slope))

"""Whitening against the Cholesky factor of the covariance that it stands for."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.inverse._reading_errors import ReadingErrors, colour, whiten

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
    _, tangent = jax.jvp(lambda apart: whiten(errors, used, apart), (first,), (way,))
    np.testing.assert_allclose(tangent, whiten(errors, used, way), rtol=1e-12)
    assert errors.variance().shape == (FRAMES, SAMPLES)
    np.testing.assert_allclose(errors.variance(), 1.0)

"""Laws of temperature: factors, and integrals whose slopes they are."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.physics.effects import PolynomialLaw, SumLaw, TabulatedLaw

# Operation by operation each size of a table has some ten programs.
factor = eqx.filter_jit(lambda law, at: law.factor(at))
integral = eqx.filter_jit(lambda law, at: law.integral(at))
POINTS = st.lists(st.floats(0.1, 100.0), min_size=2, max_size=6)


@given(POINTS, st.data())
def test_a_table_is_linear_in_between_and_constant_outside(
    gaps: list[float], data: st.DataObject
) -> None:
    at = 250.0 + np.cumsum(gaps)
    value = np.asarray(data.draw(st.lists(st.floats(0.1, 9.0), min_size=len(at), max_size=len(at))))
    law = TabulatedLaw(jnp.asarray(at), jnp.asarray(value))
    asked = np.linspace(at[0] - 50, at[-1] + 50, 101)
    np.testing.assert_allclose(factor(law, jnp.asarray(asked)), np.interp(asked, at, value))
    # The trapezoidal rule is exact between the points.
    every = np.union1d(asked, at)
    level = np.interp(every, at, value)
    areas = np.append(0.0, np.cumsum(np.diff(every) * (level[1:] + level[:-1]) / 2))
    found = np.asarray(integral(law, jnp.asarray(every)))
    np.testing.assert_allclose(found - found[0], areas, rtol=1e-9, atol=1e-9)


def test_slopes_of_integrals_are_factors() -> None:
    table = TabulatedLaw(jnp.asarray([300.0, 350.0, 420.0]), jnp.asarray([1.0, 1.7, 1.2]))
    both = SumLaw((table, PolynomialLaw(jnp.asarray([0.0, 4e-3]), 293.15)))
    at = jnp.asarray([280.0, 310.0, 349.0, 351.0, 400.0, 500.0])
    for law in (table, both):
        slope = jax.vmap(jax.grad(law.integral))(at)
        np.testing.assert_allclose(slope, law.factor(at), rtol=1e-12)
    np.testing.assert_allclose(both.factor(at), table.factor(at) + 4e-3 * (at - 293.15))


def test_a_table_is_differentiated_by_its_values() -> None:
    at, values = jnp.asarray([300.0, 400.0]), jnp.asarray([1.0, 2.0])
    slope = jax.grad(lambda one: TabulatedLaw(at, one).integral(jnp.asarray(350.0)))(values)
    # The integral from 300 K to 350 K of what is linear between the two.
    np.testing.assert_allclose(slope, [37.5, 12.5])

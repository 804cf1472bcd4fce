"""Loads of densities that vary within cells, against scikit-fem and closed forms."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import skfem

from thermo.physics import Discretisation, Model, assemble, heat_rate, volume_rule
from thermo.physics.effects import NodalSource, Schedule

from .test_matrices import bent, close, reference

SIZE = 0.02


@pytest.mark.parametrize("order", [1, 2])
def test_a_density_that_falls_off_within_cells(order: int) -> None:
    space = bent(order)
    rule = volume_rule(space, 8)
    rate = rule.load(jnp.exp(-rule.at[..., 2] / SIZE))
    basis, _, numbers = reference(order)
    fine = skfem.Basis(basis.mesh, basis.elem, intorder=8)
    expected = np.empty(len(space.mesh.nodes))
    expected[numbers] = skfem.LinearForm(lambda v, w: np.exp(-w.x[2] / SIZE) * v).assemble(fine)
    np.testing.assert_allclose(rate, expected, rtol=0, atol=2e-3 * expected.max())
    source = NodalSource(rate, Schedule(1.0))
    cells = len(space.mesh.cells)
    balance = assemble(Model(space, jnp.ones(cells), jnp.ones(cells), volume=(source,)))
    rest = jnp.zeros(len(space.mesh.nodes))
    close(np.asarray(heat_rate(balance, rest, 0.5)), np.asarray(rate))
    assert not np.asarray(heat_rate(balance, rest, 1.5)).any()


@pytest.mark.parametrize("degree", [1, 2, 5])
def test_powers_up_to_the_degree_are_exact(degree: int) -> None:
    space = bent(1)
    rule, exact = volume_rule(space, degree), volume_rule(space, 15)
    for power in range(degree + 1):
        found, wanted = (
            float((one.at[..., 1] ** power * one.weight).sum()) for one in (rule, exact)
        )
        assert found == pytest.approx(wanted, rel=1e-12)


def test_a_rule_is_made_within_a_compiled_program_as_well() -> None:
    def middle(space: Discretisation) -> jax.Array:
        rule = volume_rule(space, 2)
        return jnp.einsum("qcx,qc->x", rule.at, rule.weight)

    np.testing.assert_allclose(eqx.filter_jit(middle)(bent(1)), middle(bent(1)), rtol=1e-12)

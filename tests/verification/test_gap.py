"""Row 25 of the verification table: two plates that exchange across a gap."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.mesh import box_mesh, faces_where, mesh_from_cells, promote
from thermo.physics import (
    ConjugateGradient,
    Discretisation,
    Model,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics.effects import GapExchange, gap_exchange
from thermo.physics.integrators import BackwardEuler

from .bodies import at_sections, constant, everywhere, growing_steps, held, in_cells, simulate


def plates(section: tuple[int, int] = (1, 1), *, order: int = 1) -> Discretisation:
    """Plates [0, 0.495] and [0.505, 1] in one mesh; `section` divides the faces of each."""
    left = box_mesh((0.495, 0.1, 0.1), (3, section[0], 1))
    right = box_mesh((0.495, 0.1, 0.1), (3, section[1], 1), origin=(0.505, 0.0, 0.0))
    nodes = np.concatenate([left.nodes, right.nodes])
    cells = np.concatenate([left.cells, right.cells + len(left.nodes)])
    mesh = mesh_from_cells(nodes, cells)
    return discretise(mesh if order == 1 else promote(mesh))


def gap(space: Discretisation) -> GapExchange:
    first, second = (
        faces_where(space.mesh, lambda centre, _, x=x: np.abs(centre[:, 0] - x) < 1e-9)
        for x in (0.495, 0.505)
    )
    return gap_exchange(space, first, second, 80.0)


def test_ttlp100_gap_exchange() -> None:
    space = plates()
    x = space.mesh.nodes[:, 0]
    model = Model(
        space,
        in_cells(space, 40.0),
        in_cells(space, 1e5),
        surface=(gap(space),),
        prescribed=held(space, (x < 1e-9, constant(100)), (x > 1 - 1e-9, constant(300))),
    )
    got = simulate(
        model,
        everywhere(space, 200.0),
        growing_steps([1e7], 100.0, 1.2),
        integrator=BackwardEuler(),
    )
    flux = 200 / (2 * 0.495 / 40 + 1 / 80)
    left, right = 100 + flux * x / 40, 300 - flux * (1 - x) / 40
    exact = np.where(x < 0.5, left, right)
    np.testing.assert_allclose(got.final, exact, atol=1e-4)
    faces = np.asarray(at_sections(space, [0.495, 0.505]).read(got.final))
    np.testing.assert_allclose(faces, [166.443, 233.557], atol=1e-3)
    assert abs(100 + flux * 0.25 / 40 - 133.557) < 1e-3


@pytest.mark.parametrize("order", [1, 2])
def test_what_leaves_one_side_enters_the_other(order: int) -> None:
    space = plates(order=order)
    exchange = gap(space)
    # A temperature that varies over the section pairs every point with the one opposite.
    place = np.asarray(space.face_point)
    field = jnp.asarray(np.where(place[..., 0] < 0.5, 1.0, -2.0) * (1 + 30 * place[..., 1]))
    flux = np.asarray(exchange.flux(field, 0.0))
    side = np.asarray(exchange.conductance) > 0
    expected = -80 * np.sign(np.asarray(field)) * 3 * (1 + 30 * place[..., 1])
    np.testing.assert_allclose(flux[side], expected[side], rtol=1e-12)
    assert not flux[~side].any()
    assert abs((flux * space.face_weight).sum()) < 1e-12 * np.abs(flux * space.face_weight).sum()


def test_sides_that_do_not_match_are_refused() -> None:
    with pytest.raises(InputError, match="do not match"):
        gap(plates((1, 2)))


def test_two_insulated_plates_meet_halfway() -> None:
    space = plates()
    x = space.mesh.nodes[:, 0]
    model = Model(space, in_cells(space, 40.0), in_cells(space, 1e5), surface=(gap(space),))
    start = jnp.asarray(np.where(x < 0.5, 100.0, 300.0))
    got = simulate(model, start, uniform_steps(np.array([8e4]), 400.0), integrator=BackwardEuler())
    np.testing.assert_allclose(got.final, 200.0, atol=1e-2)


def test_derivative_by_the_conductance() -> None:
    space = plates()
    x = space.mesh.nodes[:, 0]
    exchange = gap(space)
    start = jnp.asarray(np.where(x < 0.5, 100.0, 300.0))
    grid = uniform_steps(np.array([1500.0]), 500.0)

    def loss(share: jax.Array) -> jax.Array:
        scaled = GapExchange(share * exchange.conductance, exchange.other, exchange.point)
        model = Model(space, in_cells(space, 40.0), in_cells(space, 1e5), surface=(scaled,))
        tight = ConjugateGradient(rtol=1e-13)
        end = solve_heat(model, start, grid, integrator=BackwardEuler(), solver=tight).final
        return jnp.mean(jnp.where(x < 0.5, end, 0.0))

    both = jax.jit(jax.value_and_grad(loss))
    shares = 0.5 ** np.arange(4, 9)
    value, slope = both(jnp.asarray(1.0))
    rest = [abs(float(both(jnp.asarray(1 + s))[0] - value - s * slope)) for s in shares]
    assert float(slope) > 1e-2
    assert np.polyfit(np.log(shares), np.log(rest), 1)[0] > 1.9

"""The balance of heat at the nodes: rates, stored heat, and the matrix of an implicit step."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from thermo.physics._coarse_correction import CoarseMatrices, coarse_correction, coarse_matrices
from thermo.physics._diagonal_product import diagonal_product
from thermo.physics._discretisation import (
    diagonal_of,
    mass,
    on_faces,
    stiffness_edges,
    surface_mass,
)
from thermo.physics._edge_product import difference_product, edge_product
from thermo.physics._exchange import exchange, plain_exchange, slope_of
from thermo.physics._model import Model
from thermo.physics._pattern import Rows, add_surface, expand, scale_rows
from thermo.physics._shape import reference_mass
from thermo.physics._step_matrix import StepMatrix
from thermo.physics.effects._effect import Time


@final
class Balance(eqx.Module):
    """The model with its constant matrices assembled, once for each simulation.

    - `stiffness` (edges,) [W/K]; `stored` and `stored_edges`: mass matrix [J/K].
    - `stiffness_rows`, `stored_rows`: the same, padded for products; without derivatives.
    - `coarse`: M and K in coarser spaces, or None; without derivatives.
    - `constant`: M + weight K where all steps have that weight, or None.
    - `single`: whether many matrices side by side, as tangents have, may be rounded to single
      precision.
    """

    model: Model
    stiffness: Float[Array, " edges"]
    stiffness_diagonal: Float[Array, " nodes"]
    stored: Float[Array, " nodes"]
    stored_edges: Float[Array, " edges"]
    stiffness_rows: Rows
    stored_rows: Rows
    coarse: CoarseMatrices | None
    constant: StepMatrix | None = None
    single: bool = eqx.field(static=True, default=False)


def with_weight(balance: Balance, weight: Time) -> Balance:
    """A balance whose steps all have one weight [s]: what their matrices share is made once."""
    model = balance.model
    if model.follows_temperature():
        return balance
    plain = _plain_matrix(balance, balance.stored, weight)
    constant = jax.lax.stop_gradient(StepMatrix(model.space.pattern, *plain))
    return eqx.tree_at(lambda b: b.constant, balance, constant, is_leaf=lambda x: x is None)


def assemble(model: Model, *, single: bool = False) -> Balance:
    """Assemble what does not change during a run: K [W/K] and M [J/K]; `single` as in `Balance`."""
    space = model.space
    stiffness = stiffness_edges(space, model.conductivity)
    stored, stored_edges = mass(space, model.capacity)
    fixed = jax.lax.stop_gradient((model.conductivity, model.capacity))
    return Balance(
        model=model,
        stiffness=stiffness,
        stiffness_diagonal=diagonal_of(space, stiffness),
        stored=stored,
        stored_edges=stored_edges,
        stiffness_rows=expand(space.pattern, jax.lax.stop_gradient(stiffness)),
        stored_rows=expand(space.pattern, jax.lax.stop_gradient(stored_edges)),
        coarse=coarse_matrices(space, *fixed),
        single=single,
    )


def _cell_mean(model: Model, temperature: Float[Array, " nodes"]) -> Float[Array, " cells"]:
    share = jnp.asarray(reference_mass(model.space.order).sum(1))
    return temperature[model.space.mesh.cells] @ share


def _stiffness(balance: Balance, temperature: Float[Array, " nodes"]) -> Float[Array, " edges"]:
    law = balance.model.conductivity_law
    if law is None:
        return balance.stiffness
    model = balance.model
    factor = law.factor(_cell_mean(model, temperature))
    shape = (-1,) + (1,) * (model.conductivity.ndim - 1)
    return stiffness_edges(model.space, model.conductivity * factor.reshape(shape))


@final
class Rise(eqx.Module):
    """An increment whose heat is taken from a linearisation, as in `step_matrix`.

    - `value`: (nodes,) [K]; `about`: temperatures of the linearisation, (nodes,) [K], or None for
      those that the increment adds to.
    """

    value: Float[Array, " nodes"]
    about: Float[Array, " nodes"] | None


def heat_rate(
    balance: Balance,
    temperature: Float[Array, " nodes"],
    time: Time,
    rise: Rise | None = None,
) -> Float[Array, " nodes"]:
    """Heat that flows into each node [W] at nodal temperatures [K] and a time [s].

    F_i = integral of q_in N_i over the surface + integral of q N_i - K_ij T_j; with a rise also
    what that changes, linearised.
    """
    model, space = balance.model, balance.model.space
    rate = -_conducted(balance, temperature, rise)
    if model.surface:
        value, about = (None, None) if rise is None else (rise.value, rise.about)
        local = tuple(effect for effect in model.surface if effect.local())
        if local:
            rate = rate + exchange(space, local, time, temperature, value, about)
        distant = tuple(effect for effect in model.surface if not effect.local())
        if distant:
            rate = rate + plain_exchange(space, distant, time, temperature, value, about)
    for effect in model.volume:
        rate = rate + effect.load(space, time)
    return rate


def _conducted(
    balance: Balance, temperature: Float[Array, " nodes"], rise: Rise | None
) -> Float[Array, " nodes"]:
    """K T [W], with that of a rise."""
    pattern = balance.model.space.pattern
    if balance.model.conductivity_law is None:
        whole = temperature if rise is None else temperature + rise.value
        rows, single = balance.stiffness_rows, balance.single
        return difference_product(pattern, balance.stiffness, whole, rows, single=single)
    stiffness = _stiffness(balance, temperature)
    if rise is None or rise.about is None:
        whole = temperature if rise is None else temperature + rise.value
        return difference_product(pattern, stiffness, whole)
    flow = difference_product(pattern, stiffness, temperature)
    return flow + difference_product(pattern, _stiffness(balance, rise.about), rise.value)


def stored_heat(balance: Balance, rise: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
    """M times a rise of (equivalent) temperature [K]: the heat stored at each node [J]."""
    pattern, single = balance.model.space.pattern, balance.single
    content = (balance.stored, balance.stored_edges)
    return edge_product(pattern, *content, rise, balance.stored_rows, single=single)


def equivalent(balance: Balance, temperature: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
    """Temperature [K] that would store the same heat at constant capacity."""
    law = balance.model.capacity_law
    return temperature if law is None else law.integral(temperature)


def missing_heat(
    balance: Balance,
    temperature: Float[Array, " nodes"],
    base: Float[Array, " nodes"] | None,
    time: Time,
    weight: Time,
    moved: Bool[Array | np.ndarray, ""] | None = None,
    rise: Rise | None = None,
) -> Float[Array, " nodes"]:
    """Heat [J] that a stage still lacks at each node: weight F(T, t) - M (G(T) - base).

    With a rise also less what `step_matrix` times that rise takes up, so that nothing is missing
    where the rise solves the stage.

    Arguments:

    - `temperature`: T, (nodes,) [K]; `base`: equivalent temperature at the left, (nodes,) [K], or
      None for G(T).
    - `time`: of the stage [s]; `weight`: [s].
    - `moved`: where it is known, whether T is another temperature than the base is that of.
    """
    model = balance.model
    heat = weight * heat_rate(balance, temperature, time, rise)
    above = None if base is None else equivalent(balance, temperature) - base
    if rise is not None and model.capacity_law is not None:
        factor = model.capacity_law.factor(
            _cell_mean(model, temperature if rise.about is None else rise.about)
        )
        content = mass(model.space, model.capacity * factor)
        heat = heat - edge_product(model.space.pattern, *content, rise.value)
    elif rise is not None:
        above = rise.value if above is None else above + rise.value
    if above is not None:
        heat = heat - _stored_where(moved, balance, above, held=rise is not None)
    return heat if model.prescribed is None else diagonal_product(model.prescribed.free(), heat)


def _stored_where(
    moved: Bool[Array | np.ndarray, ""] | None,
    balance: Balance,
    above: Float[Array, " nodes"],
    *,
    held: bool,
) -> Float[Array, " nodes"]:
    """Heat [J] stored above a base. Where nothing has moved it is that of a `held` rise, or none.

    A product less for all tangents at once, which such a rise has none of.
    """
    if moved is None:
        return stored_heat(balance, above)

    def still(above: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
        if held:
            return stored_heat(balance, jax.lax.stop_gradient(above))
        return jnp.zeros_like(above)

    return jax.lax.cond(moved, lambda a: stored_heat(balance, a), still, above)


def step_matrix(balance: Balance, temperature: Float[Array, " nodes"], weight: Time) -> StepMatrix:
    """M + weight J [J/K], with J = -dF/dT linearised at nodal temperatures [K]; weight in [s]."""
    balance, temperature, weight = jax.lax.stop_gradient((balance, temperature, weight))
    model, space, pattern = balance.model, balance.model.space, balance.model.space.pattern
    if balance.constant is not None:
        diagonal, rows = balance.constant.diagonal, balance.constant.rows
    else:
        diagonal, rows = _plain_matrix(balance, temperature, weight)
    held = jnp.zeros_like(diagonal)
    slope = slope_of(model.surface, on_faces(space, temperature)) if model.surface else None
    if slope is not None:
        on_diagonal, on_edges = surface_mass(space, weight * slope)
        held = jnp.pad(on_diagonal, (pattern.inner, 0))
        diagonal = diagonal + held
        rows = add_surface(pattern, rows, on_edges)
    free = None
    if model.prescribed is not None:
        free = model.prescribed.free()
        rows = scale_rows(pattern, rows, free)
        # What a coarser space lacks at a prescribed node is held by what conducts there.
        held = jnp.where(free > 0, held, diagonal)
        diagonal = jnp.where(free > 0, diagonal, 1.0)
    coarse = None
    if balance.coarse is not None:
        coarse = coarse_correction(balance.coarse, weight, held, free)
    return StepMatrix(pattern, diagonal, rows, coarse)


def _plain_matrix(
    balance: Balance, temperature: Float[Array, " nodes"], weight: Time
) -> tuple[Float[Array, " nodes"], Rows]:
    """M + weight K [J/K] at nodal temperatures [K], without the surface."""
    model, space, pattern = balance.model, balance.model.space, balance.model.space.pattern
    diagonal, rows = balance.stored, balance.stored_rows
    stiffness_diagonal, stiffness_rows = balance.stiffness_diagonal, balance.stiffness_rows
    if model.capacity_law is not None:
        factor = model.capacity_law.factor(_cell_mean(model, temperature))
        diagonal, edges = mass(space, model.capacity * factor)
        rows = expand(pattern, edges)
    if model.conductivity_law is not None:
        stiffness = _stiffness(balance, temperature)
        stiffness_diagonal = diagonal_of(space, stiffness)
        stiffness_rows = expand(pattern, stiffness)
    rows = jax.tree.map(lambda m, k: m + weight * k, rows, stiffness_rows)
    return diagonal + weight * stiffness_diagonal, rows

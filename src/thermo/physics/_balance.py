"""The balance of heat at the nodes: rates, stored heat, and the matrix of an implicit step."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics._discretisation import (
    diagonal_of,
    mass,
    on_faces,
    stiffness_edges,
    surface_load,
    surface_mass,
    volume_load,
)
from thermo.physics._edge_product import difference_product, edge_product
from thermo.physics._model import Model
from thermo.physics._pattern import expand, rewrite_surface
from thermo.physics._shape import reference_mass
from thermo.physics._sparse_operator import SparseOperator, frozen
from thermo.physics.effects._effect import Time


@final
class Balance(eqx.Module):
    """The model with its constant matrices assembled, once for each simulation.

    - `stiffness` (edges,) [W/K]; `stored` and `stored_edges`: mass matrix [J/K].
    - `stiffness_rows`, `stored_rows`: the same, padded for the solver.
    """

    model: Model
    stiffness: Float[Array, " edges"]
    stiffness_diagonal: Float[Array, " nodes"]
    stored: Float[Array, " nodes"]
    stored_edges: Float[Array, " edges"]
    stiffness_rows: Float[Array, " entries"]
    stored_rows: Float[Array, " entries"]


def assemble(model: Model) -> Balance:
    """Assemble what does not change during a run: K [W/K] and M [J/K]."""
    space = model.space
    stiffness = stiffness_edges(space, model.conductivity)
    stored, stored_edges = mass(space, model.capacity)
    return Balance(
        model=model,
        stiffness=stiffness,
        stiffness_diagonal=diagonal_of(space, stiffness),
        stored=stored,
        stored_edges=stored_edges,
        stiffness_rows=frozen(expand(space.pattern, stiffness)),
        stored_rows=frozen(expand(space.pattern, stored_edges)),
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


def heat_rate(
    balance: Balance, temperature: Float[Array, " nodes"], time: Time
) -> Float[Array, " nodes"]:
    """Heat that flows into each node [W] at nodal temperatures [K] and a time [s].

    F_i = integral of q_in N_i over the surface + integral of q N_i - K_ij T_j.
    """
    model, space = balance.model, balance.model.space
    stiffness = _stiffness(balance, temperature)
    rate = -difference_product(space.pattern, stiffness, temperature)
    if model.surface:
        at_faces = on_faces(space, temperature)
        flux = sum(effect.flux(at_faces, time) for effect in model.surface)
        rate = rate + surface_load(space, jnp.asarray(flux))
    for effect in model.volume:
        rate = rate + volume_load(space, effect.power(time))
    return rate


def stored_heat(balance: Balance, rise: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
    """M times a rise of (equivalent) temperature [K]: the heat stored at each node [J]."""
    return edge_product(balance.model.space.pattern, balance.stored, balance.stored_edges, rise)


def equivalent(balance: Balance, temperature: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
    """Temperature [K] that would store the same heat at constant capacity."""
    law = balance.model.capacity_law
    return temperature if law is None else law.integral(temperature)


def step_matrix(
    balance: Balance, temperature: Float[Array, " nodes"], weight: Time
) -> SparseOperator:
    """M + weight J [J/K], with J = -dF/dT linearised at nodal temperatures [K]; weight in [s]."""
    model, space = balance.model, balance.model.space
    diagonal, edges = balance.stored, balance.stored_edges
    stiffness, stiffness_diagonal = balance.stiffness, balance.stiffness_diagonal
    constant = model.conductivity_law is None and model.capacity_law is None
    if model.capacity_law is not None:
        factor = model.capacity_law.factor(_cell_mean(model, temperature))
        diagonal, edges = mass(space, model.capacity * factor)
    if model.conductivity_law is not None:
        stiffness = _stiffness(balance, temperature)
        stiffness_diagonal = diagonal_of(space, stiffness)
    diagonal = diagonal + weight * stiffness_diagonal
    edges = edges + weight * stiffness
    if model.surface:
        at_faces = on_faces(space, temperature)
        slopes = [effect.slope(at_faces) for effect in model.surface]
        known = [slope for slope in slopes if slope is not None]
        if known:
            on_diagonal, on_edges = surface_mass(space, jnp.asarray(sum(known)))
            diagonal = diagonal + weight * on_diagonal
            edges = edges + weight * on_edges
    if model.prescribed is not None:
        free = model.prescribed.free()
        pattern = space.pattern
        edges = edges * free[pattern.first] * free[pattern.second]
        diagonal = jnp.where(free > 0, diagonal, 1.0)
    if constant and model.prescribed is None:
        rows = balance.stored_rows + frozen(jnp.asarray(weight)) * balance.stiffness_rows
        rows = rewrite_surface(space.pattern, rows, frozen(edges))
    else:
        rows = expand(space.pattern, frozen(edges))
    return SparseOperator(space.pattern, diagonal, edges, frozen(rows))

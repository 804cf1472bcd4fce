"""What an effect on the surface takes from the body for each kelvin."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from thermo.discover._candidate import AbstractHeatCandidate
from thermo.discover._entries import Active, entry_of
from thermo.discover._standing import Standing, with_few_places
from thermo.inverse import case_model, with_fields
from thermo.physics.effects import Contact, Convection


def conductance_of(standing: Standing, active: Active) -> float | None:
    """The integral of h over all of its place [W/K]; None where an effect adds no h [W/m2/K].

    Readings tell it better than h in the middle of a place, whose edge is a guess.
    """
    small, _ = with_few_places(standing)
    number = standing.active.index(active)
    entry = entry_of(small.point, small.active[number])
    candidate = small.point.candidates[entry.kind]
    if not isinstance(candidate, AbstractHeatCandidate):
        return None
    if not entry.card.joint:
        alone = jnp.zeros_like(candidate.strength).at[entry.part]
        candidate = replace(candidate, strength=alone.set(candidate.strength[entry.part]))
    objective = small.bench.coarse
    case = jax.tree.map(lambda leaf: leaf[0], objective.cases[0])
    model = case_model(objective, with_fields(objective, small.point.fields), case)
    added = candidate.to_model(model, case.under).surface[len(model.surface) :]
    whole = [np.asarray(_film(one)) for one in added if isinstance(one, Convection | Contact)]
    if not whole:
        return None
    weight = np.asarray(objective.space.face_weight)
    return float(sum((one.reshape(len(one), -1) * weight).sum() for one in whole))


def _film(effect: Convection | Contact) -> jax.Array:
    return effect.coefficient if isinstance(effect, Convection) else effect.conductance

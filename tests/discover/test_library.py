"""All candidates of the package: absent at first, of names of their own, light on large meshes."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import LAMP, SIZE, STATED, run

from thermo.discover import Place, Setting, Transition, library
from thermo.inverse._addition import AbstractHeatAddition
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import properties
from thermo.mesh import Mesh, box_mesh
from thermo.physics import discretise

COARSE, FINE = (box_mesh(SIZE, cut) for cut in ((6, 4, 4), (12, 8, 8)))


def setting(mesh: Mesh) -> Setting:
    return Setting(mesh, 2700.0, 24.0, 290.0, 350.0)


HEAT = [one.card.name for one in library(setting(COARSE)) if isinstance(one, AbstractHeatAddition)]


def test_every_candidate_is_absent_and_has_a_name_of_its_own() -> None:
    found = library(replace(setting(COARSE), unknown=("convection",)))
    assert len({one.card.name for one in found}) == len(found) == 19
    assert all(not np.any(np.asarray(one.strength)) for one in found)
    for one in found:
        assert one.card.low <= 0 < one.card.typical <= one.card.high
        assert one.card.means and one.card.excited_by and one.card.split_by
        if isinstance(one.place, Transition):
            assert np.asarray(one.place.centre) == pytest.approx([295, 305, 315, 325, 335, 345])
        elif one.place is not None and one.place.centre is not None:
            centres = np.asarray(one.place.centre)
            assert np.all((centres > -1e-12) & (centres < np.array(SIZE) + 1e-12))
            assert len(np.unique(centres.round(9), axis=0)) == len(centres) == 32


def test_convection_may_be_wrong_all_over_where_it_is_not_fitted() -> None:
    known, fitted = (
        next(one for one in library(each) if one.card.name == "local_convection")
        for each in (setting(COARSE), replace(setting(COARSE), unknown=("scaled_convection",)))
    )
    assert (
        isinstance(known.place, Place) and len(known.strength) == 33 and len(fitted.strength) == 32
    )
    everywhere = np.asarray(known.place.shapes(jnp.asarray(COARSE.nodes))[-1])
    assert everywhere.min() > 0.9


def largest(name: str, mesh: Mesh) -> int:
    """Numbers in the largest array that a candidate makes on its way into a model."""
    space = discretise(mesh)
    body = properties(STATED, {}, len(mesh.cells), len(mesh.faces))
    under = conditions(run(lamp=LAMP), space)
    (one,) = (one for one in library(setting(mesh)) if one.card.name == name)
    model = make_model(space, body, under)

    def made(strength: jax.Array) -> list[jax.Array]:
        changed = replace(one, strength=strength).to_model(model, under)  # type: ignore[union-attr]
        return [jnp.asarray(leaf) for leaf in jax.tree.leaves(changed)]

    program = jax.make_jaxpr(made)(one.strength)
    return max(v.aval.size for line in program.jaxpr.eqns for v in line.outvars)


@pytest.mark.parametrize("name", HEAT)
def test_work_grows_with_the_mesh_and_not_with_its_square(name: str) -> None:
    assert len(FINE.cells) == 8 * len(COARSE.cells)
    # Cells by faces would be 32 times as many.
    assert largest(name, FINE) <= 9 * largest(name, COARSE)

"""Effects that were found go through a file and come back as they were."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest
from box_scene import write_block
from verdicts import verdict

from thermo.discover import Candidate, Setting, effects_as_arrays, library, load_effects
from thermo.discover._candidate import with_edge
from thermo.discover._library import setting_of
from thermo.errors import InputError
from thermo.inverse import predict, save_estimate
from thermo.observe import Scene, read_scene


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return read_scene(write_block(tmp_path_factory.mktemp("block")))


def every(scene: Scene) -> tuple[Candidate, ...]:
    """All candidates, at strengths that tell them apart."""
    found = library(setting_of(scene, scene.runs.values(), verdict("named").stated.mesh))
    return tuple(
        replace(one, strength=one.strength + number + 0.5) for number, one in enumerate(found)
    )


def test_all_candidates_come_back(scene: Scene, tmp_path: Path) -> None:
    kept = every(scene)
    saved = verdict("named").extended
    save_estimate(tmp_path / "estimate.npz", saved, effects_as_arrays(kept))
    again = load_effects(tmp_path, scene)
    assert [one.card for one in again] == [one.card for one in kept]
    for one, other in zip(kept, again, strict=True):
        assert jax.tree.structure(one) == jax.tree.structure(other)
        for leaf, same in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
            np.testing.assert_array_equal(leaf, same)


def test_few_places_come_back_as_few(scene: Scene, tmp_path: Path) -> None:
    found = verdict("named")
    save_estimate(tmp_path / "estimate.npz", found.extended, effects_as_arrays(found.additions))
    (one,) = load_effects(tmp_path, scene)
    assert one.card.name == "hidden_source" and one.strength.shape == (1,)
    assert one.place is not None and one.place.centre is not None
    np.testing.assert_array_equal(one.place.centre, [[0.01, 0.0, 0.004]])


@pytest.mark.parametrize("name", ["local_convection", "hidden_source"])
def test_a_place_with_an_edge_comes_back_as_one(scene: Scene, tmp_path: Path, name: str) -> None:
    (bell,) = (one for one in every(scene) if one.card.name == name)
    assert bell.card.edged
    even = with_edge(bell)
    saved = verdict("named").extended
    save_estimate(tmp_path / "estimate.npz", saved, effects_as_arrays((even,)))
    (again,) = load_effects(tmp_path, scene)
    assert jax.tree.structure(again) == jax.tree.structure(even) != jax.tree.structure(bell)
    for leaf, same in zip(jax.tree.leaves(even), jax.tree.leaves(again), strict=True):
        np.testing.assert_array_equal(leaf, same)


def test_a_fit_without_effects_has_none(scene: Scene, tmp_path: Path) -> None:
    save_estimate(tmp_path / "estimate.npz", verdict("no_gap").extended, effects_as_arrays(()))
    assert load_effects(tmp_path, scene) == ()


def test_effects_that_are_not_candidates_are_refused(scene: Scene, tmp_path: Path) -> None:
    def others(setting: Setting) -> tuple[Candidate, ...]:
        return tuple(one for one in library(setting) if one.card.name != "hidden_source")

    found = verdict("named")
    arrays = effects_as_arrays(found.additions)
    save_estimate(tmp_path / "estimate.npz", found.extended, arrays)
    with pytest.raises(InputError, match="not among the candidates") as caught:
        load_effects(tmp_path, scene, others)
    assert caught.value.value == "hidden_source" and "estimate.npz" in caught.value.where
    arrays.pop("0/hidden_source/.strength")
    save_estimate(tmp_path / "estimate.npz", found.extended, arrays)
    with pytest.raises(InputError, match="another version"):
        load_effects(tmp_path, scene)


def test_a_prediction_does_not_leave_effects_out_unasked(scene: Scene, tmp_path: Path) -> None:
    found = verdict("named")
    save_estimate(tmp_path / "estimate.npz", found.extended, effects_as_arrays(found.additions))
    with pytest.raises(InputError, match="effects beyond") as caught:
        predict(scene, tmp_path)
    assert caught.value.value == "hidden_source" and "load_effects" in caught.value.remedy

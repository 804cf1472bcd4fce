"""What is said of fields: closed forms of a normal distribution, and draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from posteriors import COUNT, MESH, SIZE, left, smoothness

from thermo.fields import QUANTITIES
from thermo.mesh import face_areas


def test_deviations_are_those_of_the_mixture_its_moves_and_shifts() -> None:
    found = left(smoothness(0.1, weight=0.75), smoothness(0.3, weight=0.25, move=0.2), shift=0.05)
    diagonal = 0.75 * 0.1**2 + 0.25 * (0.3**2 + 0.2**2) + 0.05**2
    assert np.allclose(np.diagonal(found.covariance), diagonal)
    assert found.covariance[0, 1] == pytest.approx(0.25 * 0.2**2 + 0.05**2)
    one = left(smoothness(0.1))
    onto = one.onto_faces("convection")
    assert np.allclose(onto.sum(1), 1.0)
    assert np.allclose(one.deviation("convection"), 0.1 * np.linalg.norm(onto, axis=1))


def test_the_mean_is_by_area_and_knows_more_than_a_face() -> None:
    found = left(smoothness(0.1, prior=2.0))
    middle, after, before = found.mean("conductivity")
    shares = face_areas(MESH) / face_areas(MESH).sum()
    along = shares @ found.onto_faces("conductivity")
    assert middle == pytest.approx(np.log(2.0))
    assert after == pytest.approx(0.1 * np.linalg.norm(along))
    assert before == pytest.approx(20 * after)
    assert after < found.deviation("conductivity").min()


def test_the_share_of_the_data_is_that_of_the_variance_they_take_away() -> None:
    assert np.allclose(left(smoothness(0.1, prior=2.0)).informed("convection"), 1 - 0.05**2)
    assert np.allclose(left(smoothness(2.0, prior=2.0)).informed("convection"), 0.0)
    eigenvalues = left(smoothness(0.5, prior=1.0)).eigenvalues()
    assert np.allclose(eigenvalues, 3.0) and len(eigenvalues) == 16


def test_a_control_by_itself_is_resolved_to_the_piece_it_stands_for() -> None:
    sharp = left(smoothness(0.01)).resolution("conductivity")
    piece = face_areas(MESH).sum() / COUNT
    assert np.allclose(sharp, np.sqrt(piece / (2 * np.pi)))
    blurred = smoothness(0.01)
    # All controls move together: only their mean is known.
    blurred = replace(blurred, covariance=np.eye(SIZE) - np.full((SIZE, SIZE), 0.99 / SIZE))
    assert np.all(left(blurred).resolution("conductivity") > 1.5 * sharp)


def test_draws_scatter_as_the_covariance_says_and_are_repeated_by_their_seed() -> None:
    found = left(smoothness(0.1, weight=0.5), smoothness(0.3, weight=0.5), shift=0.1)
    draws = found.draw(400, seed=3)
    logs = np.log([one["convection"].faces for one in draws]) - np.log(2.0)
    assert np.allclose(np.std(logs, axis=0), found.deviation("convection"), rtol=0.2)
    assert np.abs(logs.mean(0)).max() < 0.06
    again = found.draw(2, seed=3)
    same = left(smoothness(0.1, weight=0.5), smoothness(0.3, weight=0.5), shift=0.1).draw(2, seed=3)
    assert np.array_equal(again[1]["conductivity"].cells, same[1]["conductivity"].cells)


def test_draws_stay_within_what_is_physical() -> None:
    high = max(one["conductivity"].faces.max() for one in left(smoothness(30.0)).draw(5))
    assert high == QUANTITIES["conductivity"].upper

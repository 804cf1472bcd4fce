"""Where strengths, places and sizes of candidates lie in a flattened point, and in what bounds."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from lit_box import MESH

from thermo.discover import Inclusion, Place
from thermo.discover._candidate import with_edge
from thermo.discover._descent import Free
from thermo.discover._entries import (
    entries,
    entry_of,
    field_entries,
    free_entries,
    joined,
)
from thermo.discover._extended import Extended, moved, numbers, with_candidates
from thermo.discover.candidates import (
    AmbientDrift,
    LocalConvection,
    MissingRadiation,
    SensorLag,
    SupportContact,
    Void,
)

CORNERS = np.stack([MESH.nodes.min(0), MESH.nodes.max(0)])
CENTRES = jnp.asarray([[0.004, 0.006, 0.008], [0.015, 0.003, 0.008]])
DEPTHS = jnp.asarray([0.002, 0.001, 0.0008, 0.002, 0.001, 0.0008])
FIRST = (
    MissingRadiation(jnp.asarray([0.1])),
    LocalConvection(jnp.asarray([20.0, 30.0]), Place(CENTRES, jnp.asarray([0.004, 0.005]))),
    SupportContact(jnp.arange(6.0), Place(None, DEPTHS)),
    AmbientDrift(jnp.asarray([1.0, 2.0, 3.0]), duration=jnp.asarray(30.0)),
    Void(
        jnp.asarray([0.5, 0.6]),
        Inclusion(
            CENTRES,
            jnp.asarray([[1.0, 2, 3], [4, 5, 6]]) * 1e-3,
            jnp.asarray([4.0, 3.0]),
            jnp.asarray([8.0, 9.0]),
        ),
    ),
    SensorLag(jnp.asarray([1.5])),
)


@pytest.fixture(scope="module")
def point() -> Extended:
    """Two fields, of three and of two parameters, and candidates of all kinds."""
    fields = {"conductivity": jnp.asarray([0.1, 0.2, 0.3]), "convection": jnp.asarray([0.4, 0.5])}
    return Extended(fields, FIRST)


@pytest.fixture(scope="module")
def flat(point: Extended) -> np.ndarray:
    return np.asarray(ravel_pytree(point)[0])


def test_numbers_are_laid_out_as_the_point_itself(point: Extended, flat: np.ndarray) -> None:
    found = numbers(point)
    assert found.count == len(flat)
    assert jax.tree.structure(found.at) == jax.tree.structure(point)
    for where, leaf in zip(jax.tree.leaves(found.at), jax.tree.leaves(point), strict=True):
        place = np.asarray(where).astype(int)
        assert np.array_equal(place, np.asarray(where)), "numbers are whole"
        np.testing.assert_array_equal(flat[place], leaf)
    every = np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(found.at)])
    assert sorted(every) == list(range(len(flat)))


def test_each_part_is_an_entry_and_a_history_is_one(point: Extended, flat: np.ndarray) -> None:
    found = entries(point)
    names = [(one.card.name, one.part) for one in found]
    assert names == [
        ("radiation", 0),
        ("local_convection", 0),
        ("local_convection", 1),
        *(("support_contact", side) for side in range(6)),
        ("ambient_drift", 0),
        ("void", 0),
        ("void", 1),
        ("sensor_lag", 0),
    ]
    for one in found:
        candidate = point.candidates[one.kind]
        assert candidate.card is one.card
        strength = np.asarray(candidate.strength)
        wanted = strength if one.card.joint else strength[[one.part]]
        np.testing.assert_array_equal(flat[one.strengths], wanted)


def test_an_entry_is_found_by_name_and_part(point: Extended, flat: np.ndarray) -> None:
    found = entry_of(point, ("local_convection", 1))
    assert (found.kind, found.part) == (1, 1) and flat[found.strengths] == [30.0]
    with pytest.raises(StopIteration):
        entry_of(point, ("local_convection", 2))


def test_the_parameters_of_the_fields_are_free(point: Extended, flat: np.ndarray) -> None:
    free = field_entries(point, point.fields)
    np.testing.assert_array_equal(flat[free.number], [0.1, 0.2, 0.3, 0.4, 0.5])
    assert np.all(free.scale == 0.3)
    assert np.all(free.low == -np.inf) and np.all(free.high == np.inf)


def free_of(point: Extended, name: str, part: int) -> Free:
    entry = entry_of(point, (name, part))
    return free_entries(point, entry, FIRST[entry.kind], CORNERS)


def check(free: Free, flat: np.ndarray, wanted: list[tuple[float, float, float, float]]) -> None:
    """Of each free entry its value, scale and bounds."""
    found = np.stack([flat[free.number], free.scale, free.low, free.high], 1)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_a_coefficient_far_below_its_first_value_may_come_back_at_once(
    point: Extended,
) -> None:
    first = jax.tree.map(lambda leaf: leaf + np.log(100.0), point.fields)
    low, as_first = field_entries(point, first), field_entries(point, point.fields)
    np.testing.assert_allclose(low.scale, 100 * as_first.scale)
    above = jax.tree.map(lambda leaf: leaf - 3.0, point.fields)
    np.testing.assert_allclose(field_entries(point, above).scale, as_first.scale)


def test_what_has_no_place_has_its_strength_alone(point: Extended, flat: np.ndarray) -> None:
    check(free_of(point, "radiation", 0), flat, [(0.1, 0.5, -1.0, 1.0)])
    check(free_of(point, "sensor_lag", 0), flat, [(1.5, 1.0, 0.0, 60.0)])


def test_the_strengths_of_a_history_are_free_together(point: Extended, flat: np.ndarray) -> None:
    wanted = [(value, 5.0, -50.0, 50.0) for value in (1.0, 2.0, 3.0)]
    check(free_of(point, "ambient_drift", 0), flat, wanted)


def test_a_patch_may_move_within_the_body_s_box(point: Extended, flat: np.ndarray) -> None:
    wanted = [
        (30.0, 50.0, -np.inf, np.inf),
        (0.015, 0.005, 0.0, 0.020),
        (0.003, 0.005, 0.0, 0.012),
        (0.008, 0.005, 0.0, 0.008),
        (0.005, 0.0025, 0.00125, 0.020),
    ]
    check(free_of(point, "local_convection", 1), flat, wanted)


def test_a_depth_has_no_centre(point: Extended, flat: np.ndarray) -> None:
    wanted = [(4.0, 250.0, 0.0, np.inf), (0.001, 0.0005, 1e-6, 0.004)]
    check(free_of(point, "support_contact", 4), flat, wanted)


def test_three_sizes_and_the_form_are_free_each_by_itself(
    point: Extended, flat: np.ndarray
) -> None:
    wanted = [
        (0.6, 0.45, 0.0, 0.999),
        (0.015, 0.004, 0.0, 0.020),
        (0.003, 0.005, 0.0, 0.012),
        (0.008, 0.006, 0.0, 0.008),
        *((size, 0.5 * size, 0.25 * size, 4 * size) for size in (0.004, 0.005, 0.006)),
        (3.0, 2.0, 2.0, 12.0),
        (9.0, 4.0, 4.0, 24.0),
    ]
    check(free_of(point, "void", 1), flat, wanted)


def test_bounds_are_of_the_places_that_were_first(point: Extended, flat: np.ndarray) -> None:
    entry = entry_of(point, ("local_convection", 0))
    first = FIRST[1]
    assert isinstance(first, LocalConvection)
    wide = replace(first, place=Place(CENTRES, jnp.asarray([0.010, 0.005])))
    free = free_entries(point, entry, wide, CORNERS)
    size = [float(one[-1]) for one in (flat[free.number], free.scale, free.low, free.high)]
    assert size == pytest.approx([0.004, 0.005, 0.0025, 0.040])


def test_a_patch_with_an_edge_may_be_thin_beside_the_bell_that_was_first() -> None:
    first = FIRST[1]
    even = with_edge(first)
    point = Extended({}, (even,))
    entry = entry_of(point, ("local_convection", 1))
    free, flat = free_entries(point, entry, first, CORNERS), np.asarray(ravel_pytree(point)[0])
    form = [(flat[free.number[n]], free.scale[n], free.low[n], free.high[n]) for n in range(9)]
    assert form[0] == pytest.approx((30.0, 50.0, -np.inf, np.inf))
    # Twice the first bell's 0.005 m, and from a tenth of a quarter of it on.
    for one in form[4:7]:
        assert one == pytest.approx((0.010, 0.005, 0.025 * 0.010, 0.040))
    assert sorted(free.number[1:4] - free.number[1]) == [0, 1, 2]


def test_a_patch_that_is_held_along_an_axis_neither_moves_nor_grows_along_it() -> None:
    first = FIRST[1]
    even = with_edge(first)
    assert isinstance(even.place, Inclusion)
    point = Extended({}, (even,))
    entry = entry_of(point, ("local_convection", 1))
    held = np.array([False, False, True])
    every, free = (free_entries(point, entry, first, CORNERS, one) for one in (~held & held, held))
    lacking = np.setdiff1d(every.number, free.number)
    at = numbers(point).at.candidates[0].place
    assert isinstance(at, Inclusion)
    np.testing.assert_array_equal(lacking, [at.centre[1, 2], at.size[1, 2]])
    kept = np.isin(every.number, free.number)
    for name in ("number", "scale", "low", "high", "logarithm"):
        np.testing.assert_array_equal(getattr(free, name), getattr(every, name)[kept])


def test_parts_are_joined_in_their_order(point: Extended) -> None:
    some = (
        field_entries(point, point.fields),
        free_of(point, "void", 0),
        free_of(point, "sensor_lag", 0),
    )
    both = joined(*some)
    assert len(set(both.number)) == len(both.number) == sum(len(one.number) for one in some)
    np.testing.assert_array_equal(both.number, np.concatenate([one.number for one in some]))
    np.testing.assert_array_equal(both.high, np.concatenate([one.high for one in some]))
    ways = both.ways(numbers(point).count)
    assert ways.shape == (len(both.number), numbers(point).count)
    np.testing.assert_array_equal(ways[np.arange(len(ways)), both.number], both.scale)
    assert np.count_nonzero(ways) == len(ways)


def test_a_point_moves_entry_by_entry(point: Extended, flat: np.ndarray) -> None:
    change = np.zeros(len(flat))
    free = free_of(point, "void", 1)
    change[free.number] = [0.1, 1e-3, 0, 0, 0, 0, 2e-3, 0.5, 0]
    after = moved(point, change)
    void, before = after.candidates[4], point.candidates[4]
    assert isinstance(void, Void) and isinstance(before, Void)
    np.testing.assert_allclose(void.strength, [0.5, 0.7])
    np.testing.assert_allclose(void.place.centre[1], [0.016, 0.003, 0.008])
    np.testing.assert_allclose(void.place.size[1], [0.004, 0.005, 0.008])
    np.testing.assert_allclose(void.place.size[0], before.place.size[0])
    np.testing.assert_allclose(void.place.squareness, [4.0, 3.5])
    for name, values in point.fields.items():
        np.testing.assert_array_equal(after.fields[name], values)
    np.testing.assert_allclose(ravel_pytree(after)[0], flat + change, rtol=1e-14)
    np.testing.assert_array_equal(ravel_pytree(point)[0], flat)


def test_other_candidates_leave_the_fields(point: Extended) -> None:
    other = with_candidates(point, FIRST[:1])
    assert other.candidates == FIRST[:1] and other.fields is point.fields
    assert numbers(other).count == 6

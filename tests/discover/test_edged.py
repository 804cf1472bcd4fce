"""Places that end at an edge, in place of bells."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import MESH, SIZE
from standings import SAMPLES, standing
from verdicts import one_round

from thermo.discover import Inclusion, Place, _edged
from thermo.discover._bench import Bench
from thermo.discover._candidate import SHARPNESS, with_edge
from thermo.discover._edged import _starts, on_one_side, with_an_edge
from thermo.discover._extended import Extended
from thermo.discover._pace import silent
from thermo.discover._standing import Standing
from thermo.discover.candidates import HiddenSource, LocalConvection, SensorLag, SupportContact
from thermo.inverse import Ready
from thermo.mesh import box_mesh

LOWER = MESH.nodes.min(0)[2]
CENTRES = jnp.asarray([[0.006, 0.006, float(LOWER)], [0.012, 0.004, 0.004]])
BELL = LocalConvection(jnp.asarray([40.0, 0.0]), Place(CENTRES, jnp.asarray([0.003, 0.002])))

SMALL = replace(BELL, place=Place(CENTRES, jnp.asarray([0.0015, 0.002])))


def test_an_even_patch_takes_as_much_as_the_bell_and_is_as_wide() -> None:
    even = with_edge(BELL).place
    assert isinstance(even, Inclusion) and isinstance(BELL.place, Place)
    across = np.linspace(-0.02, 0.02, 801)
    plane = np.stack([*np.meshgrid(across, across, indexing="ij"), 0 * np.ones((801, 801))], -1)
    at = jnp.asarray(plane) + CENTRES[0]
    bell, patch = np.asarray(BELL.place.shapes(at)[0]), np.asarray(even.shapes(at)[0])
    # It begins between a disc and a square.
    assert 0.5 * patch.sum() == pytest.approx(bell.sum(), rel=0.25)
    wide = [np.sqrt((one * plane[..., 0] ** 2).sum() / one.sum()) for one in (bell, patch)]
    assert wide[1] == pytest.approx(wide[0], rel=0.15)
    lag = SensorLag(jnp.ones(1))
    assert with_edge(lag) is lag and with_edge(with_edge(BELL)).place is not None


def test_a_patch_begins_on_one_side_of_the_body() -> None:
    found = on_one_side(BELL, 0, MESH)
    place = found.place
    assert isinstance(place, Inclusion)
    np.testing.assert_allclose(found.strength, [20.0, 0.0])
    np.testing.assert_allclose(place.size, [[0.006, 0.006, 0.0015], [0.004, 0.004, 0.004]])
    second = place.only(1)
    np.testing.assert_array_equal(second.size, place.size[1:])
    np.testing.assert_array_equal(second.centre, CENTRES[1:])
    np.testing.assert_array_equal(second.shapes(CENTRES), place.shapes(CENTRES)[1:])
    top = jnp.asarray([0.006, 0.006, float(MESH.nodes.max(0)[2])])
    assert float(place.shapes(top)[0]) < 1e-6 < float(BELL.place.shapes(top)[0])


def test_a_patch_begins_on_a_skin_that_is_flat_there() -> None:
    fine = box_mesh(SIZE, (20, 12, 8))
    deep = CENTRES.at[0, 2].add(0.001)
    found = on_one_side(replace(BELL, place=Place(deep, jnp.asarray([0.0015, 0.002]))), 0, fine)
    assert isinstance(found.place, Inclusion)
    np.testing.assert_allclose(found.place.centre, CENTRES.at[0, 2].set(LOWER), atol=1e-12)


FAR = np.full((SAMPLES, 3), 1.0)


def read_at(points: np.ndarray) -> SimpleNamespace:
    """A run of that name, as far as is looked at."""
    return SimpleNamespace(name="run", recording=SimpleNamespace(points=points))


def tried(
    monkeypatch: pytest.MonkeyPatch,
    left: float,
    *,
    bell: Any = BELL,
    smooth: float = 20.0,
    burst: bool = False,
    points: np.ndarray = FAR,
    whole: float = 60.0,
    rough: float = 1.0,
    second: float = 58.0,
) -> tuple[Standing, Standing, list[str]]:
    """Where a search stands with a bell, and after an even patch that leaves so much was tried.

    `rough`: what is left in smooth shapes by the first that is tried; the `second` leaves so much.
    """
    name, told = bell.card.name, []
    here = standing(whole, 5, smooth, ((name, 0),))
    ready = object.__new__(Ready)
    object.__setattr__(ready, "mesh", MESH)
    bench = object.__new__(Bench)
    object.__setattr__(bench, "ready", ready)
    object.__setattr__(bench, "task", SimpleNamespace(runs=(read_at(points),)))
    object.__setattr__(here, "bench", bench)
    object.__setattr__(here, "point", Extended({}, (SensorLag(jnp.zeros(1)), bell)))

    def fitted(there: Standing, *, times: int) -> Standing:
        if there.ended is not here.ended:
            return there  # measured anew, and nothing changes
        told.append(type(there.point.candidates[1].place).__name__)
        assert times == 1
        first = len(told) == 1
        made = standing(left if first else second, 9, rough if first else 1.0, there.active)
        object.__setattr__(made, "held", there.held)
        object.__setattr__(made, "bench", bench)
        object.__setattr__(made, "point", there.point)
        if burst:
            made.ended.residual[:] = np.inf
        return made

    monkeypatch.setattr(_edged, "fitted", fitted)
    monkeypatch.setattr(
        _edged, "effect_of", lambda one, *_: replace(one_round([], 0.9).effect, strength=7.0)
    )
    monkeypatch.setattr(_edged, "rms", lambda one: {"lamp": 0.01})
    rounds = [one_round(["first"], 0.6), one_round([name], 0.6)]
    after, made = with_an_edge(here, rounds, standing(90.0, 2, 60.0), 9.0, silent())
    assert made[0] is rounds[0] and (after is here) == (made[1] is rounds[1])
    if after is not here:
        assert made[1].effect.strength == 7.0 and made[1].rms_after == {"lamp": 0.01}
        assert made[1].closed > 0.8 and made[1].together == [name]
    return here, after, told


def test_it_is_taken_where_it_explains_more(monkeypatch: pytest.MonkeyPatch) -> None:
    here, after, told = tried(monkeypatch, 20.0)
    assert told == ["Inclusion"] and after is not here
    assert isinstance(after.point.candidates[1].place, Inclusion)
    # It goes around the edges of the floor there; a smaller one is flat on it, and stays there.
    assert not after.held[(BELL.card.name, 0)].any()
    _, after, _ = tried(monkeypatch, 20.0, bell=SMALL)
    np.testing.assert_array_equal(after.held[(BELL.card.name, 0)], [False, False, True])


def test_a_source_keeps_its_power_and_lies_as_deep(monkeypatch: pytest.MonkeyPatch) -> None:
    source = HiddenSource(jnp.full(1, 3.0), Place(CENTRES[:1], jnp.full(1, 0.002)))
    _, after, told = tried(monkeypatch, 20.0, bell=source)
    found = after.point.candidates[1]
    assert told == ["Inclusion"] and isinstance(found.place, Inclusion)
    assert not after.held[(source.card.name, 0)].any()
    np.testing.assert_array_equal(found.strength, [3.0])
    np.testing.assert_allclose(found.place.size, np.full((1, 3), 0.004))


@pytest.mark.parametrize(
    ("left", "more", "times"),
    [
        (58.0, {}, 1),  # four more entries, for nothing
        (20.0, {"burst": True}, 2),
    ],
)
def test_it_is_left_where_it_does_not(
    monkeypatch: pytest.MonkeyPatch, left: float, more: dict[str, bool], times: int
) -> None:
    here, after, told = tried(monkeypatch, left, **more)
    assert told == times * ["Inclusion"] and after is here


def test_around_an_edge_of_the_body_a_patch_begins_soft() -> None:
    for bell, wanted in ((SMALL, [SHARPNESS[0], SHARPNESS[1]]), (BELL, SHARPNESS[1::-1])):
        places = [one.place for one in _starts(bell, 0, MESH)]
        found = [float(one.sharpness[0]) for one in places if isinstance(one, Inclusion)]
        assert found == list(wanted)


@pytest.mark.parametrize(("first", "second"), [(40.0, 20.0), (20.0, 40.0)])
def test_the_better_of_two_is_taken_where_the_first_leaves_a_misfit(
    monkeypatch: pytest.MonkeyPatch, first: float, second: float
) -> None:
    here, after, told = tried(
        monkeypatch, first, second=second, rough=10.0, whole=400.0, bell=SMALL
    )
    assert told == 2 * ["Inclusion"] and after is not here
    assert 2 * after.ended.loss() == pytest.approx(20.0)
    place = after.point.candidates[1].place
    assert isinstance(place, Inclusion)
    # The second begins with edges as soft as they can be.
    assert float(place.sharpness[0]) == (SHARPNESS[1] if second < first else SHARPNESS[0])
    assert float(place.size[0, 2]) == (0.003 if second < first else 0.00075)


@pytest.mark.parametrize(
    ("leaves", "count", "end"),
    [
        ([39.9], 1, 39.9),  # nothing changes any more
        ([60.0, 55.0, 54.0], 3, 54.0),  # what cells make wrong was another thing where it began
        ([80.0, 60.0, 80.0, 60.0, 80.0, 60.0, 80.0], 6, 60.0),  # for ever
        ([60.0, np.inf], 2, 60.0),
    ],
)
def test_a_place_that_moved_is_fitted_until_it_stays(
    monkeypatch: pytest.MonkeyPatch, leaves: list[float], count: int, end: float
) -> None:
    made: list[float] = []

    def fitted(there: Standing, *, times: int) -> Standing:
        assert times == 1
        made.append(leaves[len(made)])
        if np.isfinite(made[-1]):
            return standing(made[-1], 9)
        lost = standing(90.0, 9)
        lost.ended.residual[:] = np.inf
        return lost

    monkeypatch.setattr(_edged, "fitted", fitted)
    after = _edged._settled(standing(40.0, 9), 4.0)
    assert len(made) == count and 2 * after.ended.loss() == pytest.approx(end)


def test_it_is_not_tried_where_a_bell_will_do_or_nothing_else_can_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    support = SupportContact(jnp.ones(1), Place(None, jnp.ones(1)))
    for more in ({"smooth": 1.0}, {"bell": with_edge(BELL)}, {"bell": support}):
        here, after, told = tried(monkeypatch, 20.0, **more)
        assert after is here and told == []


def test_a_misfit_at_samples_near_by_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    # Of a residual that is no more than noise in smooth shapes: within three sizes, and beyond.
    for away, wanted in ((0.0089, ["Inclusion"]), (0.0091, [])):
        points = FAR.copy()
        points[2:] = np.asarray(CENTRES[0]) + [away, 0.0, 0.0]
        _, after, told = tried(monkeypatch, 20.0, smooth=1.0, points=points, whole=600.0)
        assert told == wanted and after.active == ((BELL.card.name, 0),)

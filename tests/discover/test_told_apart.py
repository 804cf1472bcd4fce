"""What held-out runs say of effects that fitted ones do not tell apart, on paths made by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import HOT, LAMP, MESH, STATED, run
from scipy.stats import chi2
from standings import standing
from verdicts import fitted_in, held, one_round

from thermo.discover import Calibration, HeldOut, _told_apart
from thermo.discover._at_rest import KNOWN
from thermo.discover._bench import Bench
from thermo.discover._entries import Active
from thermo.discover._pace import silent
from thermo.discover._path import SearchPath
from thermo.discover._refits import Refit
from thermo.discover._scores import ScoreTable
from thermo.discover._standing import Standing
from thermo.discover._told_apart import (
    excluded,
    half_and_third,
    refuted,
    told_apart,
    wrong_at_rest,
)
from thermo.discover.candidates import CameraEmissivity, HeaterPower
from thermo.inverse import Ready, Task
from thermo.mesh import box_mesh

from .lit_objective import box_task, objective, partly, standing_at

NAMES = ("hidden_source", "sensor_lag", "void")


def proof(*left: float) -> dict[str, HeldOut]:
    """Runs that were not fitted, on which so much is left over the noise [1]."""
    return {f"run {n}": held(50.0, 0.05 * one) for n, one in enumerate(left)}


def sizes(found: Mapping[str, HeldOut]) -> dict[str, float]:
    """What is left, by run [K]."""
    return {run: one.rms_after for run, one in found.items()}


def apart(
    monkeypatch: pytest.MonkeyPatch,
    left: Mapping[str, float],
    word: str = "inseparable",
    *,
    cells: bool = False,
    at_rest: str = "",
    wrong: Sequence[str] = NAMES,
    smooth: Mapping[str, float] = MappingProxyType({}),
    fitted: Mapping[str, tuple[Active, ...]] = MappingProxyType({}),
) -> tuple[SearchPath, Mapping[str, HeldOut], list[str]]:
    """A path whose last effect is the first of some that explain the fitted runs alike.

    Of them quiet frames speak against those that are `wrong`, and so does the variance of `smooth`
    shapes that they leave, by name [1]. Rivals were `fitted` beside nothing, if not beside others.
    """
    there = {
        name: standing(60.0, 2, smooth.get(name, 1.0), active=fitted.get(name, ((name, 0),)))
        for name in left
    }
    first, *others = left
    told: list[str] = []
    refits = []
    for name in others:
        one = object.__new__(Refit)
        object.__setattr__(one, "standing", there[name])
        object.__setattr__(one, "begun", standing(90.0, 2, 60.0))
        monkeypatch.setattr(Refit, "name", lambda self: self.standing.active[-1][0])
        refits.append(one)
    for one in there.values():
        object.__setattr__(one, "bench", None)

    def predicted(bench: None, before: Any, point: Any) -> dict[str, HeldOut]:
        told.append(point)
        return proof(left[point])

    for name, one in there.items():
        object.__setattr__(one, "point", name)
    fakes: dict[str, Any] = {
        "held_out": predicted,
        "wrong_at_rest": lambda _, one: at_rest if one.active[-1][0] in wrong else "",
        "half_and_third": lambda *_: (None, None) if cells else None,
        "with_all": lambda refit, _: refit.standing,
        "undoubted": lambda one, _: one,
        "with_doubt": lambda one, _: one,
        "effect_of": lambda one, *_: replace(
            one_round([], 0.9).effect, chance=float(NAMES.index(one.point))
        ),
        "alternative_of": lambda one, *_: fitted_in(one.point),
        "rms": lambda one: {"lamp": float(NAMES.index(one.point))},
        "with_joint_effects": lambda rounds, *_: rounds,
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(_told_apart, name, fake)
    table = object.__new__(ScoreTable)
    begun: Standing = there[first]
    path = SearchPath(
        word, [one_round(list(left), 0.99)], begun, there[first], table, ["before"],
        Calibration(np.ones(9), 0.04, 0.01, 0.05), refits,
    )  # type: ignore[arg-type]  # fmt: skip
    after, found = told_apart(path, silent())
    for one in after.rounds:
        assert list(one.alternatives) == one.together[1:]
        assert all(name == each.effect.card.name for name, each in one.alternatives.items())
    return after, found, told


def test_a_camera_of_another_scale_is_refuted_by_what_it_read_of_a_warm_body_at_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = (run("cold", lamp=LAMP, quiet=True), run("hot", initial=HOT, quiet=True))
    right = objective(runs)
    task = partly(Task, runs=runs)
    bench = partly(Bench, coarse=right, task=task)
    plain, wrong = (
        replace(standing_at(right, CameraEmissivity(jnp.asarray([one]))), bench=bench)
        for one in (0.0, -0.1)
    )
    words = wrong_at_rest(plain, wrong)
    kelvins = 0.1 * (HOT - runs[0].initial_temperature)
    assert f"quiet frames of cold would be {kelvins:.2g} K higher" in words and "hot" in words
    assert wrong_at_rest(plain, plain) == ""
    # A camera that is off before one of the runs for another reason is nothing against a lamp.
    (case,) = right.cases
    assert case.resting is not None
    off = replace(right, cases=(replace(case, resting=case.resting + jnp.array([0.0, 3.0])),))
    bench = partly(Bench, coarse=off, task=task)
    lamp = HeaterPower(jnp.asarray([0.2]))
    before, after = (
        replace(standing_at(right, *some), bench=bench)
        for some in ((replace(lamp, strength=jnp.zeros(1)),), (lamp,))
    )
    assert wrong_at_rest(before, after) == ""

    # A run without quiet frames is none that could tell: 12 is much for one degree of freedom.
    three = objective((*runs, run("unseen")))
    gain = (24.0**0.5) * KNOWN / (HOT - runs[0].initial_temperature)
    bench = partly(Bench, coarse=three, task=partly(Task, runs=(*runs, run("unseen"))))
    plain, slight = (
        replace(standing_at(three, CameraEmissivity(jnp.asarray([one]))), bench=bench)
        for one in (0.0, gain)
    )
    assert chi2.isf(_told_apart._BY_REST, 1) < 12 < chi2.isf(_told_apart._BY_REST, 2)
    assert "quiet frames of hot" in wrong_at_rest(plain, slight)

    there = {"inseparable": words, "named": ""}
    for word, told in there.items():
        path, *_ = apart(monkeypatch, {"void": 1.0}, word, at_rest=told)
        assert path.word == ("none_of_mine" if told else word)
        assert path.remarks == (["before", told] if told else ["before"])


CAMERA = "quiet frames of cooling would be 2.1 K higher than they are."


def test_where_quiet_frames_speak_against_the_effect_at_work_one_that_explains_takes_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left = {"hidden_source": 1.0, "sensor_lag": 1.04, "void": 1.05}
    path, found, told = apart(
        monkeypatch, left, "named", at_rest=CAMERA, wrong=NAMES[:1], smooth={"sensor_lag": 40.0}
    )
    # A slow sensor leaves two thirds of the gap.
    assert path.word == "named" and path.rounds[0].together == ["void"]
    assert path.standing.active == (("void", 0),) and path.rounds[0].rms_after == {"lamp": 2.0}
    assert path.rounds[0].closed == 1.0 and path.rounds[0].effect.chance == 2.0
    assert sizes(found) == sizes(proof(1.05)) and told == ["hidden_source", "void"]
    assert path.remarks == ["before", f"{CAMERA} void takes the place of hidden_source."]

    both, *_ = apart(monkeypatch, left, "named", at_rest=CAMERA, wrong=NAMES[:1])
    assert both.word == "inseparable" and both.rounds[0].together == ["sensor_lag", "void"]


def test_what_takes_a_place_has_to_hold_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    left = {"hidden_source": 1.0, "void": 60.0}
    monkeypatch.setattr(
        f"{__name__}.proof", lambda *one: {"cooling": held(0.1, 0.05 * one[0], 0.5, (0.4, 0.6))}
    )
    path, found, _ = apart(monkeypatch, left, "named", at_rest=CAMERA, wrong=NAMES[:1])
    assert path.word == "none_of_mine" and sizes(found) == {"cooling": 3.0}
    assert "does not hold on cooling" in path.remarks[-1]


def test_beside_other_effects_than_those_at_work_nothing_is_known_of_a_rival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left = {"hidden_source": 1.0, "void": 1.0}
    # Of the pair that a rival was fitted in one effect has been taken out since.
    pair = (("radiation", 0), ("void", 0))
    for active, word in (((("void", 0),), "named"), (pair, "none_of_mine")):
        path, *_ = apart(
            monkeypatch, left, "named", at_rest=CAMERA, wrong=NAMES[:1], fitted={"void": active}
        )
        assert path.word == word and CAMERA in path.remarks[1]


def test_one_that_leaves_far_more_on_another_run_is_excluded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, found, _ = apart(monkeypatch, {"hidden_source": 1.05, "sensor_lag": 20.0})
    assert path.word == "named" and path.rounds[0].together == ["hidden_source"]
    assert sizes(found) == sizes(proof(1.05)) and path.rounds[0].effect.chance == 0.0
    assert path.remarks[0] == "before" and "sensor_lag leaves 1 K on run 0" in path.remarks[1]
    assert "hidden_source 0.0525 K" in path.remarks[1] and "no proof" in path.remarks[1]


def test_where_the_effect_at_work_is_excluded_the_best_takes_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left = {"hidden_source": 100.0, "sensor_lag": 1.3, "void": 1.1}
    path, found, told = apart(monkeypatch, left)
    assert path.word == "inseparable" and path.rounds[0].together == ["void", "sensor_lag"]
    assert path.rounds[0].effect.chance == 2.0 and path.rounds[0].rms_after == {"lamp": 2.0}
    assert path.standing.active == (("void", 0),) and sizes(found) == sizes(proof(1.1))
    assert sorted(told) == sorted(left)
    assert path.rounds[0].alternatives["sensor_lag"].held_out == sizes(proof(1.3))


@pytest.mark.parametrize("left", [(1.0, 1.2), (5.0, 9.0), (60.0, 90.0)])
def test_where_they_leave_much_alike_all_stay(
    monkeypatch: pytest.MonkeyPatch, left: tuple[float, float]
) -> None:
    path, found, _ = apart(monkeypatch, dict(zip(NAMES, left, strict=False)))
    (one,) = path.rounds
    assert path.word == "inseparable" and one.together == list(NAMES[:2])
    assert path.remarks == ["before"] and sizes(found) == sizes(proof(left[0]))
    assert one.alternatives["sensor_lag"].held_out == sizes(proof(left[1]))


def test_one_that_is_named_has_no_rivals_to_be_predicted(monkeypatch: pytest.MonkeyPatch) -> None:
    path, _, told = apart(monkeypatch, {"hidden_source": 9.0, "void": 1.0}, word="named")
    assert path.word == "named" and told == ["hidden_source"] and path.remarks == ["before"]


@pytest.mark.parametrize(("doubt", "against"), [(0.0, True), (0.1, True), (0.15, False)])
def test_noise_may_be_as_large_as_its_estimate_may_be_wrong(doubt: float, against: bool) -> None:
    # 0.062 K are 1.24 times the noise, 1.1 times what it may be from a doubt of 0.138 on.
    assert refuted(held(0.1, 0.062, 0.8, (0.7, 0.9), doubt)) is against


@pytest.mark.parametrize(
    ("after", "closed", "interval", "against"),
    [
        (0.055, 0.2, (0.1, 0.3), False),  # as good as noise
        (0.07, 0.8, (0.7, 0.98), False),  # enough may be closed
        (0.07, 0.8, (0.7, 0.97), True),
        (0.12, -0.3, (-0.5, -0.1), True),
        (0.07, 0.2, None, False),  # too few samples to be sure
        (0.12, -0.3, None, True),
        (0.12, None, None, True),  # there was nothing to close
    ],
)
def test_a_run_speaks_against_what_surely_leaves_too_much(
    monkeypatch: pytest.MonkeyPatch,
    after: float,
    closed: float | None,
    interval: tuple[float, float] | None,
    against: bool,
) -> None:
    one = held(0.1, after, closed, interval)
    assert refuted(one) is against
    monkeypatch.setattr(f"{__name__}.proof", lambda *_: {"cooling": one})
    for word in ("named", "none_of_mine", "no_gap"):
        path, found, _ = apart(monkeypatch, {"hidden_source": 1.0}, word=word)
        speaks = against and word == "named"
        assert path.word == ("none_of_mine" if speaks else word) and found["cooling"] is one
        assert len(path.remarks) == 1 + speaks and len(path.rounds) == 1
        if speaks:
            assert "does not hold on cooling: 0.1 K become" in path.remarks[-1]
            told = "% closed, less than the 97.75 %" in path.remarks[-1]
            assert told == (closed is not None)


@pytest.mark.parametrize(
    ("small", "spared"),
    [
        (0.07, False),  # cells are not what is left
        (0.066, False),
        (0.062, True),  # 0.0539 K if as much is left again as smaller cells took off
        (0.051, True),
        (0.08, False),  # it grew
    ],
)
def test_what_cells_may_leave_on_a_run_does_not_speak_against_an_effect(
    monkeypatch: pytest.MonkeyPatch, small: float, spared: bool
) -> None:
    left = iter([0.07, 0.07, small])
    monkeypatch.setattr(
        f"{__name__}.proof", lambda *_: {"cooling": held(0.1, next(left), 0.5, (0.4, 0.6))}
    )
    path, found, told = apart(monkeypatch, {"hidden_source": 1.0}, "named", cells=True)
    assert path.word == ("named" if spared else "none_of_mine") and len(told) == 3
    assert found["cooling"].rms_after == small, "the proof is that of the smaller cells"
    _, said = path.remarks
    if spared:
        assert "2 times as short as a fit's leave 0.07 K" in said and "3 times" in said
    else:
        assert "does not hold on cooling" in said


INF = float("inf")


@pytest.mark.parametrize("word", ["named", "none_of_mine"])
def test_what_leads_to_temperatures_that_there_cannot_be_is_not_named(
    monkeypatch: pytest.MonkeyPatch, word: str
) -> None:
    path, found, told = apart(monkeypatch, {"hidden_source": INF}, word, cells=True)
    assert path.word == "none_of_mine" and len(told) == 1, "smaller cells do not help"
    assert "cannot be on run 0" in path.remarks[-1] and len(path.remarks) == 2
    assert found["run 0"].rms_after == found["run 0"].rms_before == 50.0


def test_of_rivals_one_that_leads_to_such_temperatures_is_excluded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, found, _ = apart(monkeypatch, {"hidden_source": INF, "void": 1.1})
    assert path.word == "named" and path.rounds[0].together == ["void"]
    assert sizes(found) == sizes(proof(1.1)) and len(path.remarks) == 2
    assert "hidden_source leaves temperatures that there cannot be on run 0" in path.remarks[-1]
    path, found, _ = apart(monkeypatch, {"hidden_source": INF, "void": INF})
    assert path.word == "none_of_mine" and sizes(found) == {"run 0": 50.0}


def test_smaller_cells_may_find_such_temperatures_where_large_ones_do_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left = iter([0.07, 0.07, INF])
    monkeypatch.setattr(
        f"{__name__}.proof", lambda *_: {"cooling": held(0.1, next(left), 0.5, (0.4, 0.6))}
    )
    path, found, told = apart(monkeypatch, {"hidden_source": 1.0}, "named", cells=True)
    assert path.word == "none_of_mine" and len(told) == 3 and len(path.remarks) == 2
    assert sizes(found) == {"cooling": 0.1}


@pytest.mark.parametrize("same", [True, False])
def test_cells_of_half_and_a_third_predict_where_a_search_stayed_on_its_mesh(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, same: bool
) -> None:
    first, other = (Ready(MESH, STATED, {}, {}, {}, {}) for _ in range(2))
    half, third = (box_mesh((0.02, 0.02, 0.02), (count, 2, 2)) for count in (2, 3))
    # It may have gone on to cells of a third already.
    here = Bench(box_task(tmp_path), first, objective(), third)
    monkeypatch.setattr(_told_apart, "finest", lambda bench: replace(bench, finer=third))
    monkeypatch.setattr(_told_apart, "mesh_for", lambda task, stated, by: half)
    found = half_and_third(here, replace(here, ready=first if same else other))
    if same:
        assert found is not None and [one.finer for one in found] == [half, third]
    else:
        assert found is None, "about a place cells are small already"
    monkeypatch.setattr(_told_apart, "finest", lambda bench: bench)
    assert half_and_third(here, here) is None, "the surface has no smaller cells"


def test_one_that_holds_on_another_run_stays_where_its_rival_is_refuted() -> None:
    there = {
        name: {"cooling": held(0.1, after, closed, (closed - 0.05, closed + 0.05))}
        for name, after, closed in [
            ("one", 0.07, 0.7),
            ("other", 0.052, 1.0),
            ("third", 0.06, 0.95),
        ]
    }
    assert set(excluded(there)) == {"one"}, "far from thirty times as much is left"
    assert excluded({"one": there["one"]}) == {}, "all are refuted"
    # One far off, with nothing to be sure by, and one refuted: the latter is all that is left.
    far = {"cooling": held(10.0, 5.0)}
    assert set(excluded({"one": there["one"], "far": far})) == {"far"}


@given(st.floats(0.01, 1e4))
def test_of_two_that_hold_one_is_excluded_in_five_per_cent_at_the_most(scale: float) -> None:
    # One is within noise by chance, and the other one far from it.
    within, beyond = chi2.cdf(1 / scale, 1), chi2.sf(_told_apart._BEYOND / scale, 1)
    assert within * beyond < 0.05


@given(st.lists(st.floats(0.9, 1.3), min_size=1, max_size=3), st.floats(1.5, 50.0))
def test_the_mean_over_runs_counts(good: list[float], bad: float) -> None:
    found = excluded({"one": proof(*good), "other": proof(*good[:-1], bad)})
    more = (sum(one**2 for one in good[:-1]) + bad**2) / len(good) - 1
    assert set(found) == ({"other"} if more > 30 else set())

"""Candidates of installed packages join the library."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from thermo.discover import Candidate, Card, Setting, _registered, library, only, registered
from thermo.discover.candidates import HeaterPower
from thermo.errors import InputError
from thermo.mesh import box_mesh

SETTING = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 2700.0, 30.0, 290.0, 340.0)


def with_points(monkeypatch: pytest.MonkeyPatch, *points: EntryPoint) -> None:
    def found(group: str) -> tuple[EntryPoint, ...]:
        return tuple(one for one in points if one.group == group)

    monkeypatch.setattr(_registered, "entry_points", found)


def point(name: str, group: str = "thermo.candidates") -> EntryPoint:
    return EntryPoint("mine", f"{__name__}:{name}", group)


def mine(setting: Setting) -> tuple[Candidate, ...]:
    (lamp,) = (one for one in library(setting) if isinstance(one, HeaterPower))
    return (lamp,)


def broken(setting: Setting) -> Any:
    raise ValueError(f"no idea of {setting.duration} s")


def test_without_others_there_is_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    with_points(monkeypatch, point("mine", "somebody.else"))
    assert [one.card for one in registered(SETTING)] == [one.card for one in library(SETTING)]


def test_those_of_a_package_follow(monkeypatch: pytest.MonkeyPatch) -> None:
    with_points(monkeypatch, point("mine"))
    found = registered(SETTING)
    assert len(found) == len(library(SETTING)) + 1
    assert isinstance(found[-1], HeaterPower) and isinstance(found[-1].card, Card)
    assert replace(found[-1]).card.name == "heater_power"


@pytest.mark.parametrize(
    ("name", "told"), [("broken", "no idea of 30.0 s"), ("nothing", "nothing")]
)
def test_one_that_fails_is_named(monkeypatch: pytest.MonkeyPatch, name: str, told: str) -> None:
    with_points(monkeypatch, point(name))
    with pytest.raises(InputError, match="candidates cannot be made") as caught:
        registered(SETTING)
    assert "thermo.candidates: mine" in caught.value.where and told in str(caught.value.value)


def test_those_that_are_asked_for_keep_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    with_points(monkeypatch)
    found = only(("void", "radiation"))(SETTING)
    assert [one.card.name for one in found] == ["radiation", "void"]


@pytest.mark.parametrize(("names", "told"), [(("void", "ghost"), "ghost"), ((), "none")])
def test_one_that_nobody_registered_is_named(
    monkeypatch: pytest.MonkeyPatch, names: tuple[str, ...], told: str
) -> None:
    with_points(monkeypatch)
    with pytest.raises(InputError, match="there is no") as caught:
        only(names)(SETTING)
    assert caught.value.value == told and "heater_power" in str(caught.value.limit)
    with pytest.raises(InputError, match="did you mean heater_lag?"):
        only(["heater_lags"])(SETTING)

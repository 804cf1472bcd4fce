"""When cells are made smaller about a place, and what is said of it."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import within
from standings import standing
from verdicts import one_round

from thermo.discover import Place
from thermo.discover import _small_cells as module
from thermo.discover._bench import Bench
from thermo.discover._extended import Extended
from thermo.discover._pace import silent
from thermo.discover.candidates import (
    CameraDrift,
    HiddenSource,
    InDepthAbsorption,
    SupportContact,
    Void,
)
from thermo.errors import InputError
from thermo.inverse import Ready, Task

PLACE = Place(jnp.zeros((1, 3)), jnp.ones(1))


def test_the_thinnest_place_at_work_is_that_of_a_void_along_its_shortest_axis() -> None:
    flat = within((0.0, 0.0, 0.0), [0.004, 0.005, 0.003])
    lag = CameraDrift(jnp.ones(1))
    foot = SupportContact(jnp.ones(6), Place(None, jnp.full(6, 1e-6)))
    source = HiddenSource(jnp.ones(1), PLACE)
    point = Extended({}, (Void(jnp.ones(1), flat), lag, source, foot))

    def at_work(*names: str) -> Standing:
        made = standing(60.0, 2, active=tuple((name, 0) for name in names))
        object.__setattr__(made, "point", point)
        return made

    assert module.thinnest(at_work("void")) == pytest.approx(0.003)
    assert module.thinnest(at_work("hidden_source", "void")) == pytest.approx(0.003)
    assert module.thinnest(at_work("hidden_source")) == 1.0
    assert module.placed(at_work("void")) and not module.placed(at_work(lag.card.name))
    assert module.thinnest(at_work("hidden_source", "support_contact")) == 1.0, "cuts faces"
    assert module.placed(at_work("support_contact"))
    edges = module.edges(at_work("hidden_source", "void"))
    np.testing.assert_array_equal(edges, flat.edge(0))
    assert len(module.edges(at_work("hidden_source"))) == 0


def test_light_that_goes_deeper_asks_for_small_cells_where_it_enters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    light = InDepthAbsorption(jnp.ones(2), Place(None, jnp.array([4e-4, 1e-3])))
    made = standing(60.0, 2, active=(("in_depth_absorption", 1),))
    bench, task = object.__new__(Bench), object.__new__(Task)
    object.__setattr__(task, "runs", ("lamp",))
    for name, value in {"task": task, "finer": "fine"}.items():
        object.__setattr__(bench, name, value)
    object.__setattr__(made, "bench", bench)
    object.__setattr__(made, "point", Extended({}, (light,)))
    skin = np.array([[0.01, 0.01, 0.008]])
    monkeypatch.setattr(module, "lit_skin", lambda *given: skin if given[1] == "fine" else None)
    np.testing.assert_array_equal(module.edges(made), skin)
    assert module.thinnest(made) == pytest.approx(1e-3) and module.placed(made)


def small_cells(
    monkeypatch: pytest.MonkeyPatch,
    smooth: float,
    place: Place | None,
    *,
    again: bool = False,
    edge: float = 0.5,
    after: float = 0.05,
    fault: InputError | None = None,
    burst: float | None = None,
) -> list[str]:
    """What is said where an effect of size one leaves so much in smooth shapes.

    On smaller cells simulations may `burst`, and leave so much.
    """

    def resolved(bench: Bench, _: Any) -> Bench:
        if fault is not None:
            raise fault
        return bench

    began, now = (standing(60.0, 2, smooth, (("hidden_source", 0),)) for _ in range(2))
    for one, ready in ((began, object.__new__(Ready)), (now, object.__new__(Ready))):
        bench = object.__new__(Bench)
        object.__setattr__(bench, "ready", ready)
        object.__setattr__(one, "bench", bench)
        source = HiddenSource(jnp.zeros(1), PLACE)
        object.__setattr__(one, "point", Extended({}, (source,)))
        object.__setattr__(one, "first", {"hidden_source": source})
    if not again:
        object.__setattr__(now, "bench", began.bench)
    if place is None:
        object.__setattr__(now, "point", Extended({}, (CameraDrift(jnp.zeros(1)),)))
        object.__setattr__(now, "active", (("camera_drift", 0),))
    sizes = iter([{"lamp": 0.2, "dark": 0.05}, {"lamp": after, "dark": 0.05}])
    fakes: dict[str, Any] = {
        "resolved": resolved,
        "edge_of": lambda bench: edge,
        "fitted": lambda made, **_: made if burst is None else standing(burst, 2, 600.0),
        "rms": lambda _: next(sizes),
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(module, name, fake)
    remarks: list[str] = []
    found = [one_round(["hidden_source"], 0.7)]
    _, rounds = module.on_small_cells(
        now, found, began, standing(900.0, 1, 600.0), silent(), remarks
    )  # fmt: skip
    if fault is not None or burst is not None:
        assert rounds[0].closed == 0.7, "what was found stays"
    elif remarks:
        assert rounds[0].rms_after == {"lamp": 0.05, "dark": 0.05}
        # Of 599 beyond noise in one smooth shape that is left.
        assert rounds[0].closed == pytest.approx((600 - smooth) / 599)
    return remarks


def test_cells_are_made_smaller_once_about_a_place_that_leaves_a_misfit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (told,) = small_cells(monkeypatch, 40.0, PLACE)
    assert "beside hidden_source: lamp 0.2 to 0.05 K." in told, "of what changes alone"
    assert small_cells(monkeypatch, 40.0, PLACE, again=True) == []
    assert small_cells(monkeypatch, 1.0, PLACE) == [], "nothing is left"
    assert len(small_cells(monkeypatch, 1.0, PLACE, edge=1.1)) == 1, "cells are too large for it"
    assert small_cells(monkeypatch, 40.0, None) == [], "no place is at work"
    assert small_cells(monkeypatch, 40.0, PLACE, after=0.20004) == [], "nothing to tell of"


@pytest.mark.parametrize("left", [1e9, np.inf, np.nan])
def test_smaller_cells_on_which_an_effect_bursts_are_not_gone_to(
    monkeypatch: pytest.MonkeyPatch, left: float
) -> None:
    (told,) = small_cells(monkeypatch, 40.0, PLACE, burst=left)
    assert "With hidden_source at work smaller cells leave more than without it" in told


def test_where_no_smaller_cells_can_be_made_the_search_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fault = InputError(
        "the mesher did not finish", where="surface.ply", value="stopped after 600 s",
        limit="600 s", remedy="simplify the surface",
    )  # fmt: skip
    (told,) = small_cells(monkeypatch, 40.0, PLACE, fault=fault)
    assert told == (
        "Cells beside hidden_source stay as they are: the mesher did not finish, "
        "stopped after 600 s; simplify the surface."
    )

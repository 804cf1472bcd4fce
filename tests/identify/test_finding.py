"""Verdicts: a value that is known, one that hides, one that the prior alone makes narrow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import Finding, identifiability
from thermo.inverse import Sensitivity

NAMES = ("conductivity", "convection", "emissivity")
VALUES = (0.8, 20.0, 0.9)
FRAMES, SAMPLES = 6, 5


def at(
    *, size: float = 1.0, values: tuple[float, ...] = VALUES, names: tuple[str, ...] = NAMES
) -> Sensitivity:
    slopes = size * np.random.default_rng(0).standard_normal((FRAMES, SAMPLES, len(names)))
    return Sensitivity(names, {"a": slopes}, {"a": 0.05}, values=values)


def verdicts(of: Sensitivity, prior: dict[str, float] | None = None) -> dict[str, Finding]:
    found = identifiability(of, prior=prior, model_error=0.0)
    return {item.name: item for item in found.findings}


def test_strong_effects_are_identified_and_the_interval_is_that_of_the_spectrum() -> None:
    of = at()
    found = identifiability(of, model_error=0.0)
    matrix = of.slopes["a"].reshape(-1, 3) / 0.05
    relative = np.sqrt(np.diagonal(np.linalg.inv(matrix.T @ matrix)))
    for item, value, wanted in zip(found.findings, VALUES, relative, strict=True):
        assert item.verdict == "identified" and item.informed > 0.99
        assert item.value == pytest.approx(value) and item.relative == pytest.approx(
            wanted, rel=1e-3
        )
        assert item.sd == pytest.approx(value * item.relative)
        ends = value * np.exp([-1.96 * wanted, 1.96 * wanted])
        assert item.interval95 == pytest.approx(ends, rel=1e-3) or item.name == "emissivity"
    assert found.findings[2].interval95[1] <= 1.0, "an emissivity ends at 1"
    assert found.free == [] and " known to" in found.sentences()[0]
    assert "to be known to" in found.sentences(before=True)[0]


def test_what_cells_and_steps_make_wrong_moves_a_fit_and_counts_as_its_error() -> None:
    model, random = 0.02, np.random.default_rng(5)
    apart = 0.1 * random.standard_normal((FRAMES, SAMPLES))
    of = replace(at(), staying={"a": 0.01}, defect={"a": apart})
    rows = of.slopes["a"].transpose(1, 0, 2).reshape(-1, 3)
    one = 0.05**2 * np.eye(FRAMES) + model**2 + 0.01**2
    weight = np.linalg.inv(np.kron(np.eye(SAMPLES), one))
    covariance = np.linalg.inv(rows.T @ weight @ rows)
    moved = covariance @ rows.T @ weight @ apart.T.ravel()
    wanted = np.sqrt(np.diagonal(covariance) + moved**2)
    found = identifiability(of, model_error=model).findings
    assert [item.relative for item in found] == pytest.approx(wanted, rel=1e-3)
    plain = identifiability(replace(of, defect={}), model_error=model).findings
    assert all(a.relative > b.relative for a, b in zip(found, plain, strict=True))


def test_less_of_an_effect_is_weak_and_then_nothing() -> None:
    assert {item.verdict for item in verdicts(at(size=0.05)).values()} == {"weak"}
    assert {item.verdict for item in verdicts(at(size=1e-4)).values()} == {"not_identified"}


def test_a_narrow_prior_identifies_nothing() -> None:
    found = verdicts(at(size=1e-4), dict.fromkeys(NAMES, 0.01))
    assert {item.verdict for item in found.values()} == {"not_identified"}
    assert all(item.relative < 0.011 and item.informed < 0.01 for item in found.values())


@pytest.mark.parametrize("prior", [None, dict.fromkeys(NAMES, 0.3)])
def test_of_two_that_hide_behind_each_other_neither_is_identified(
    prior: dict[str, float] | None,
) -> None:
    of = at()
    of.slopes["a"][..., 2] = of.slopes["a"][..., 0]
    told = identifiability(of, prior=prior, model_error=0.0)
    found = {item.name: item.verdict for item in told.findings}
    assert found == {
        "conductivity": "not_identified", "emissivity": "not_identified", "convection": "identified"
    }  # fmt: skip
    assert any("leave to the prior" in one and "emissivity" in one for one in told.sentences())
    assert any("look alike" in one for one in told.sentences())


def test_a_value_on_its_bound_is_said_to_be_there() -> None:
    found = verdicts(at(values=(0.8, 20.0, 1.0)))
    assert found["emissivity"].verdict == "at_bound" and found["convection"].verdict == "identified"


def test_several_values_of_one_quantity_count_by_their_mean() -> None:
    names = ("conductivity", "conductivity", "heater_power")
    of = at(names=names, values=(1.0, 4.0, 1.0))
    found = verdicts(of)
    assert list(found) == ["conductivity", "heater_power"]
    assert found["conductivity"].value == pytest.approx(2.0)
    assert found["heater_power"].unit == "1"
    matrix = of.slopes["a"].reshape(-1, 3) / 0.05
    covariance = np.linalg.inv(matrix.T @ matrix)
    mean = np.array([0.5, 0.5, 0.0])
    wanted = np.sqrt(mean @ covariance @ mean)
    assert found["conductivity"].relative == pytest.approx(wanted, rel=1e-3)


def test_an_interval_of_no_width_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        identifiability(at(), wanted=0.0)
    assert caught.value.where == "wanted"

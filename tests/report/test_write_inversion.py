"""The record of a fit."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from verdicts import estimate

from thermo.inverse import ScaleEffect
from thermo.report import inversion_record, inversion_table


def test_a_scale_is_stated_where_it_is_rough() -> None:
    exact = estimate(0.0)
    assert "scale" not in inversion_record(exact, {})
    effect = ScaleEffect(0.02, {"conductivity": -2.0}, {"conductivity": 0.03})
    record = inversion_record(replace(exact, scale=effect), {})
    assert json.loads(json.dumps(record["scale"])) == {
        "relative_deviation": 0.02,
        "relative_change_per_scale": {"conductivity": -2.0},
        "deviation_without": {"conductivity": 0.03},
        "deviation_with": {"conductivity": pytest.approx(0.05)},
        "share_of_variance": {"conductivity": pytest.approx(0.64)},
    }


def test_a_scale_that_moves_nothing_has_no_share() -> None:
    effect = ScaleEffect(0.02, {"conductivity": 0.0}, {"conductivity": 0.0})
    assert effect.share("conductivity") == 0.0 and effect.total("conductivity") == 0.0


@pytest.mark.parametrize(
    ("low", "high", "ends"), [(1.5, 1.5, ["-", "-"]), (1.4, 1.7, ["1.4", "1.7"])]
)
def test_a_field_that_is_the_same_all_over_is_one_number(
    low: float, high: float, ends: list[str]
) -> None:
    field = {"unit": "W/m/K", "median": 1.5, "p05": low, "p95": high}
    fit = {"rmse": {"lamp": 0.05}, "noise": {"lamp": 0.04}}
    lines = inversion_table({"fields": {"conductivity": field}, "fit": fit}).splitlines()
    assert lines[2].split() == ["conductivity", "W/m/K", "1.5", *ends]

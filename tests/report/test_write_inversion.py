"""The record of a fit."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from verdicts import estimate

from thermo.inverse import ScaleEffect
from thermo.report import inversion_record


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

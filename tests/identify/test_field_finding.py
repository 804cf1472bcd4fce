"""Verdicts on the means of fields, and what is said of places."""

from __future__ import annotations

import numpy as np
import pytest
from posteriors import left, smoothness

from thermo.errors import InputError
from thermo.identify import field_findings, field_sentences


def test_a_field_that_data_know_is_identified_at_its_geometric_mean() -> None:
    found = left(smoothness(0.02, prior=2.0))
    for item, name in zip(field_findings(found), ("conductivity", "convection"), strict=True):
        _, after, _ = found.mean(name)
        assert item.name == name and item.value == pytest.approx(2.0)
        assert item.relative == pytest.approx(after) and item.verdict == "identified"
        assert item.interval95[1] == pytest.approx(2.0 * np.exp(1.95996 * after), rel=1e-4)
        assert item.informed == pytest.approx(1 - 1e-4)


def test_what_the_prior_alone_makes_narrow_is_not_identified() -> None:
    verdicts = {item.verdict for item in field_findings(left(smoothness(0.02, prior=0.02)))}
    assert verdicts == {"not_identified"}


def test_the_sentence_says_how_well_places_are_known() -> None:
    found = left(smoothness(0.5, prior=0.6))
    told, _ = field_sentences(found)
    half = np.expm1(1.96 * np.median(found.deviation("conductivity")))
    assert f"{100 * half:.2g} % on half of the faces" in told
    assert "On 100% of the surface what a place differs by" in told


def test_a_width_of_nothing_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        field_findings(left(smoothness(0.1)), wanted=0.0)
    assert caught.value.where == "wanted"

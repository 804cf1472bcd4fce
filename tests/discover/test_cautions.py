"""Words beside effects that were found: lit sides, unknown signs, proof by few samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lit_box import LAMP, MESH, run
from verdicts import candidacies, held, one_round

from thermo.discover._cautions import cautions, samples_off
from thermo.discover._verdict import Round
from thermo.discover.candidates import SupportContact

RUNS = [run("lamp", lamp=LAMP), run("cooling")]
assert RUNS[0].heater is not None
NORMAL = -RUNS[0].heater.direction
AXIS = int(np.argmax(np.abs(NORMAL)))
LIT = f"{'+' if NORMAL[AXIS] > 0 else '-'}{'xyz'[AXIS]}"
DARK = f"{'-' if NORMAL[AXIS] > 0 else '+'}{'xyz'[AXIS]}"


def at(side: str | None) -> Round:
    """A contact at a side."""
    one = replace(one_round(["support_contact"], 1.0), candidates=[])
    return replace(one, effect=replace(one.effect, card=SupportContact.card, side=side))


@pytest.mark.parametrize(("side", "count"), [(LIT, 1), (DARK, 0), (None, 0)])
def test_what_lies_against_a_lit_side_is_doubted(side: str | None, count: int) -> None:
    told = cautions([at(side)], RUNS, {}, 0.5)
    assert len(told) == count
    if count:
        assert "Under the lamp of lamp the side" in told[0] and "support contact" in told[0]


@pytest.mark.parametrize(
    ("ends", "count"), [((-0.2, 0.1), 1), ((0.0, 0.1), 0), ((0.1, 0.2), 0), ((-0.2, -0.1), 0)]
)
def test_a_sign_that_is_not_known_is_told(ends: tuple[float, float], count: int) -> None:
    one = one_round(["hidden_source"], 1.0)
    told = cautions([replace(one, effect=replace(one.effect, interval95=ends))], RUNS, {}, 0.5)
    assert len(told) == count and all("nor its sign" in words for words in told)


@pytest.mark.parametrize(("left", "count"), [(3e-4, 1), (2e-3, 0), (None, 0)])
def test_a_rival_that_is_excluded_by_little_is_told(left: float | None, count: int) -> None:
    source, lag = candidacies()
    one = replace(one_round(["hidden_source"], 1.0), candidates=[source, replace(lag, left=left)])
    told = cautions([one], RUNS, {}, 0.5)
    assert len(told) == count
    if count:
        assert told[0].startswith("sensor lag leaves 0.03 % of what hidden source closes, ")
        assert told[0].endswith(f"{source.card.split_by}.")
    # What is in the set is told there.
    both = replace(one, together=["hidden_source", "sensor_lag"])
    assert cautions([both], RUNS, {}, 0.5) == []


def test_proof_by_few_samples_is_no_more_than_it_is() -> None:
    sure, few, met = held(1.0, 0.9, 0.2, (0.1, 0.3)), held(1.0, 0.9, 0.2), held(1.0, 0.09, 0.99)
    told = cautions([], RUNS, {"sure": sure, "few": few, "met": met}, 0.5)
    assert len(told) == 1 and told[0].startswith("few has too few samples")
    assert "18 times its noise" in told[0]


def test_what_could_have_been_missed_is_told_for_noise_alone() -> None:
    assert cautions([], RUNS, {}, 0.02) == []
    (told,) = cautions([], RUNS, {}, 0.001)
    assert "for noise alone" in told


def test_samples_that_lie_off_the_surface_are_counted() -> None:
    size = float(np.linalg.norm(np.ptp(MESH.nodes, axis=0)))
    top = MESH.nodes.max(0)
    points = np.tile(MESH.nodes.mean(0), (5, 1))
    points[:, 2] = top[2] + size * np.array([0.0, 0.01, 0.019, 0.021, 0.05])
    (told,) = samples_off([run("lamp", points=points)], MESH)
    assert told.startswith("2 of 5 samples of lamp lie more than")
    assert f"the farthest {1e3 * 0.05 * size:.2g} mm" in told
    assert samples_off([run("lamp", points=points[:3])], MESH) == []

"""A verdict as plain data and in words."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from verdicts import held, verdict

from thermo.discover import Inclusion
from thermo.discover.candidates import (
    AmbientDrift,
    AnisotropicConductivity,
    LatentHeat,
    LocalConvection,
    SupportContact,
)
from thermo.report import discovery_record, discovery_table, write_discovery

WORDS = {
    "named": "Missing effect: hidden source, 1.25 W [1.211, 1.289], at (10.0, 0.0, 4.0) mm "
    "fading over 5 mm. Its strength: heat released inside, taken up where it is negative.",
    "inseparable": "Cannot tell hidden source from sensor lag. What would: a run without a lamp",
    "none_of_mine": "explains it; the closest is hidden source, at (10.0, 0.0, 4.0) mm fading "
    "over 5 mm, which closes 40 % of it. What was fitted, conductivity, bends to it, and is no "
    "measurement.",
    "no_gap": "No gap: simulation and readings differ by no more than noise and numerics.",
}  # fmt: skip


@pytest.mark.parametrize("word", WORDS)
def test_each_verdict_says_what_it_is(word: str) -> None:
    record = discovery_record(verdict(word))
    assert record["verdict"] == word and WORDS[word] in " ".join(record["sentences"])
    named = ["hidden_source"] if word in ("named", "inseparable") else []
    assert record["effects"] == named and record["remarks"] == ["A remark."]
    proof = " ".join(record["sentences"])
    with_it = " with what comes closest" if word == "none_of_mine" else ""
    falls = f"falls from 0.4 to 0.055 K{with_it}, at a noise"
    told = "is 0.4 K, at a noise" if word == "no_gap" else falls
    assert f"On other, which was not fitted, the difference {told}" in proof


def test_a_set_is_told_with_what_the_model_holds_and_what_would_stand_in_its_place() -> None:
    at = "at (10.0, 0.0, 4.0) mm fading over 5 mm"
    source = f"The model holds hidden source, 1.25 W [1.211, 1.289], {at}."
    lag = " In its place would stand sensor lag, 0.8 s [0.604, 0.996]"
    beside = " (with conductivity 2.3 W/m/K [2.2, 2.4], emissivity 0.85 [0.8, 0.9])."
    found = verdict("inseparable")
    (one,) = found.rounds
    sensor = one.alternatives["sensor_lag"]
    values = {**sensor.parameters, "emissivity": (0.85, (0.8, 0.9))}
    more = {"sensor_lag": replace(sensor, parameters=values)}
    found = replace(found, rounds=[replace(one, alternatives=more)])
    assert discovery_record(found)["sentences"][1] == source + lag + beside
    # Of an earlier round the unknowns are those without what came later.
    two = replace(found, rounds=[*found.rounds, *verdict("named").rounds])
    first, second, held = discovery_record(two)["sentences"][:3]
    assert first.startswith("Cannot tell") and second.startswith("Missing effect")
    assert held == f"{source}{lag}."
    said = " ".join(discovery_record(verdict("named"))["sentences"])
    assert "The model holds" not in said
    # What is merely closest is in no model.
    none = replace(verdict("none_of_mine"), rounds=found.rounds)
    assert "The model holds" not in " ".join(discovery_record(none)["sentences"])


@pytest.mark.parametrize(
    ("before", "after", "told", "wrong"),
    [
        (5.9, 7.4, "rises from 5.9 to 7.4 K", True),
        (0.051, 0.052, "rises from 0.051 to 0.052 K", False),
        (0.4, 0.3, "falls from 0.4 to 0.3 K", False),
    ],
)
def test_a_run_on_which_it_does_not_hold_says_so(
    before: float, after: float, told: str, wrong: bool
) -> None:
    proof = {"other": held(before, after)}
    said = " ".join(discovery_record(replace(verdict("named"), held_out=proof))["sentences"])
    assert told in said and ("does not hold there" in said) == wrong


def test_the_contract_of_a_round() -> None:
    (one,) = discovery_record(verdict("named"))["rounds"]
    assert one["named"] == one["set"] == ["hidden_source"] and one["unit"] == "W"
    assert one["location"] == {"centre": [0.01, 0.0, 0.004], "size": 0.005}
    assert one["conductance"] is one["conductance_interval95"] is None
    found = verdict("named")
    (alone,) = found.rounds
    centre, widths = jnp.array([[0.01, 0.0, 0.004]]), jnp.array([[5e-3, 3e-3, 1e-3]])
    outline = Inclusion(centre, widths, jnp.full(1, 3.5), jnp.full(1, 9.0))
    ended = replace(alone, effect=replace(alone.effect, outline=outline))
    (edged,) = discovery_record(replace(found, rounds=[ended]))["rounds"]
    shape = {"half_widths": [5e-3, 3e-3, 1e-3], "squareness": 3.5, "sharpness": 9.0}
    assert edged["location"] == {**one["location"], "middle": [0.01, 0.0, 0.004], **shape}
    assert one["rms_before"]["lamp"] == 0.5 and one["rms_after"]["lamp"] == 0.05
    (other,) = discovery_record(verdict("inseparable"))["rounds"]
    assert other["named"] == [] and other["set"] == ["hidden_source", "sensor_lag"]
    lag = other["alternatives"]["sensor_lag"]
    assert one["alternatives"] == {} and lag["rms"] == {"lamp": 0.051, "cooling": 0.06}
    assert (lag["strength"], lag["interval95"], lag["unit"]) == (0.8, [0.604, 0.996], "s")
    assert lag["parameters"]["conductivity"] == {"value": 2.3, "interval95": [2.2, 2.4]}
    assert lag["held_out"] == {"other": 0.056}
    (closest,) = discovery_record(verdict("none_of_mine"))["rounds"]
    assert closest["named"] == [], "what does not explain the gap is not named"
    record = discovery_record(verdict("named"))
    assert record["could_have_missed"]["void"] == {
        "strength": None, "unit": "1", "found_in": {"0.5": 0.9, "0.8": None, "0.95": None},
    }  # fmt: skip
    assert record["could_have_missed"]["sensor_lag"]["strength"] == 0.06
    assert record["held_out"]["other"]["gap_closed"] == 0.97
    lamp = record["over_time"]["lamp"]
    assert lamp["before"]["follows"]["lamp"] == {"score": -8.0, "lag_s": 1.5, "p_value": 0.0}
    assert lamp["after"]["slow_p_value"] == 0.25
    assert record["over_time"]["cooling"]["after"] == {"slow_p_value": 0.6, "follows": {}}
    assert record["held_out"]["other"]["gap_closed_interval95"] == [0.95, 0.98]
    assert "hidden_source" in discovery_table(record)
    # A sensor does not read what is still to come.
    for one in record["candidates"]:
        assert (one["least"], one["most"]) == ((None, None) if one["unit"] == "W" else (0.0, 60.0))
        one["strength"] = -one["strength"]
    lines = discovery_table(record).splitlines()
    assert "-1.3" in lines[2] and "below 0" in lines[3]


def test_files_and_page_are_left(tmp_path: Path) -> None:
    record = discovery_record(verdict("named")) | {"object": "a cup", "seconds": 3.0}
    out = tmp_path / "not" / "there"
    write_discovery(str(out), verdict("named"), record)
    assert json.loads((out / "verdict.json").read_text())["effects"] == ["hidden_source"]
    assert (out / "estimate.npz").exists()
    page = (out / "verdict.html").read_text("utf-8")
    assert "a cup: what is missing" in page and WORDS["named"] in page


def test_a_change_of_phase_is_told_with_its_temperature() -> None:
    made = verdict("named")
    (one,) = made.rounds
    effect = replace(
        one.effect, card=LatentHeat.card, strength=2e4, interval95=(1.8e4, 2.2e4), centre=None,
        size=None, transition=(312.34, 4.5),
    )  # fmt: skip
    record = discovery_record(replace(made, rounds=[replace(one, effect=effect)]))
    assert record["rounds"][0]["transition"] == {"temperature": 312.34, "width": 4.5}
    assert record["rounds"][0]["location"] is None
    told = "Missing effect: latent heat, 2e+04 J/kg [1.8e+04, 2.2e+04], at 312.3 K, over 4.5 K."
    assert record["sentences"][0].startswith(told)


def test_a_history_is_told_from_end_to_end() -> None:
    made = verdict("named")
    (one,) = made.rounds
    assert discovery_record(made)["rounds"][0]["strengths"] is None
    drift = replace(one.effect, card=AmbientDrift.card, strength=8.0, strengths=(1.0, 3.0, 8.0))
    told = discovery_record(replace(made, rounds=[replace(one, effect=drift)]))
    assert told["rounds"][0]["strengths"] == [1.0, 3.0, 8.0]


def test_what_reads_alike_is_told_beside_an_effect() -> None:
    made = verdict("named")
    (one,) = made.rounds
    effect = replace(one.effect, card=LocalConvection.card, centre=np.array([0.01, -1e-9, 0.004]))
    for strength, ending in [(1.25, " It may as well be a support under that place."), (-1.25, "")]:
        effect = replace(effect, strength=strength)
        told = discovery_record(replace(made, rounds=[replace(one, effect=effect)]))
        middle = f" Its strength: {LocalConvection.card.means}."
        assert told["sentences"][0].endswith(f"mm fading over 5 mm.{middle}{ending}")


def test_a_place_that_ends_at_an_edge_is_told_with_its_half_widths() -> None:
    made = verdict("named")
    (one,) = made.rounds
    size = jnp.asarray([[0.006, 0.0041, 0.001]])
    for middle, about in [(0.01, ""), (0.012, " about (12.0, 0.0, 4.0) mm")]:
        centre = jnp.asarray([[middle, 0.0, 0.004]])
        outline = Inclusion(centre, size, jnp.asarray([4.0]), jnp.asarray([8.0]))
        even = replace(one, effect=replace(one.effect, outline=outline))
        told = discovery_record(replace(made, rounds=[even]))["sentences"][0]
        where = "at (10.0, 0.0, 4.0) mm within half-widths of (6.0, 4.1, 1.0) mm"
        assert f"{where}{about}. Its" in told


@pytest.mark.parametrize(
    ("word", "interval"), [("named", [1.9, 2.1]), ("no_gap", [1.9, 2.1]), ("none_of_mine", None)]
)
def test_an_unknown_has_an_interval_unless_nothing_explains_the_gap(
    word: str, interval: list[float] | None
) -> None:
    found = discovery_record(verdict(word))["parameters"]
    assert found == {"conductivity": {"before": 2.2, "after": 2.0, "interval95": interval}}


def test_a_film_is_told_over_all_of_its_place() -> None:
    made = verdict("named")
    (one,) = made.rounds
    film = replace(
        one.effect, card=SupportContact.card, conductance=0.03141, conductance95=(0.0251, 0.0377)
    )
    told = discovery_record(replace(made, rounds=[replace(one, effect=film)]))
    assert told["rounds"][0]["conductance"] == 0.03141
    assert told["rounds"][0]["conductance_interval95"] == [0.0251, 0.0377]
    assert "fading over 5 mm, 0.0314 W/K [0.0251, 0.0377] in all." in told["sentences"][0]


def test_a_support_is_told_with_its_side_and_depth() -> None:
    made = verdict("named")
    (one,) = made.rounds
    told = "W/m2/K [1.211, 1.289], at the side -z"
    for depth, more in [(6e-4, ", to a depth of 0.6 mm."), (6e-6, ". Its strength")]:
        foot = replace(one.effect, card=SupportContact.card, side="-z", depth=depth, size=0.02)
        made = discovery_record(replace(verdict("named"), rounds=[replace(one, effect=foot)]))
        assert (made["rounds"][0]["side"], made["rounds"][0]["depth"]) == ("-z", depth)
        assert told + more in made["sentences"][0]


def test_an_effect_along_an_axis_is_told_with_that() -> None:
    made = verdict("named")
    (one,) = made.rounds
    grain = replace(one.effect, card=AnisotropicConductivity.card, centre=None, part="along z")
    told = discovery_record(replace(made, rounds=[replace(one, effect=grain)]))
    assert told["rounds"][0]["part"] == "along z"
    assert told["sentences"][0].startswith("Missing effect: anisotropic conductivity along z, 1.25")


def test_a_drift_is_told_with_its_rises_in_turn() -> None:
    made = verdict("named")
    (one,) = made.rounds
    drift = replace(one.effect, card=AmbientDrift.card, centre=None, strengths=(0.5, 0.25, 1.25))
    told = discovery_record(replace(made, rounds=[replace(one, effect=drift)]))
    assert "1.25 K [1.211, 1.289], in turn 0.5, 0.25, 1.25." in told["sentences"][0]


def test_where_nothing_explains_the_gap_residuals_are_those_of_the_stated_model() -> None:
    found = discovery_record(verdict("named"))["residuals"]["lamp"]
    samples = len(found["points"])
    assert max(found["by_sample"]["before"]) > 5 * max(found["by_sample"]["after"])
    assert len(found["by_sample"]["after"]) == samples
    assert found["by_frame"]["before"][0] == 0 < found["by_frame"]["before"][-1]
    bare = discovery_record(verdict("none_of_mine"))["residuals"]
    assert bare["lamp"]["by_sample"]["after"] is bare["lamp"]["by_frame"]["after"] is None
    # What is closest is predicted on runs that were not fitted all the same.
    assert bare["other"]["by_frame"] == {"before": [0.4] * 3, "after": pytest.approx([0.055] * 3)}
    assert bare["other"]["by_sample"]["before"] == pytest.approx([0.4] * 2)
    calm = discovery_record(verdict("no_gap"))["residuals"]["other"]
    assert calm["time"] == [0.0, 5.0, 10.0] and calm["by_frame"]["after"] is None
    told = discovery_record(verdict("named"))["gap"]["lamp"]
    assert told["before"]["changing"] == {"squares": 1584.0, "expected": 176}

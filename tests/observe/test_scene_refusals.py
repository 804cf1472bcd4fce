"""Every mistake in a scene folder is refused with file, key, value, limit and remedy."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.observe import read_scene

DELETE = object()
LAMP = "runs.lamp"
HEATER = f"{LAMP}.heater"
AIR = f"{LAMP}.air.0"
HISTORY = f"{LAMP}.prescribed.0"
KELVIN = "at least 150, at most 5000"
NULL = "a number, or null where"

# name: dotted key that is changed, its value, and what the message must hold:
# key in `where` ("" for the same key), value, limit, remedy.
BAD: dict[str, tuple[str, Any, str, str, str, str]] = {
    "format_2": ("format", "thermofield-scene/2", "", "scene/2", "thermofield-scene/1", "update"),
    "format_absent": ("format", DELETE, "", "null", "thermofield-scene/1", "write"),
    "unknown_key": ("colour", "red", "", "'red'", "known keys: format", "remove `colour`"),
    "misspelt_key": ("surfase_exchange", {}, "", "{}", "surface_exchange", "`surface_exchange`?"),
    "surface_absent": ("surface", DELETE, "", "format, object", "required keys", "add `surface`"),
    "surface_no_file": ("surface", "no.ply", "no.ply", "no such file", "existing", "check"),
    "surface_number": ("surface", 3, "", "3", "a text", "write `surface`"),
    "unit_feet": ("unit", "feet", "", "'feet'", "m, cm, mm, inch", "unit of the surface"),
    "object_list": ("object", [1], "", "[1]", "a text", "write `object`"),
    "material_absent": ("material", DELETE, "", "format", "required keys", "add `material`"),
    "material_list": ("material", [], "", "[]", "an object", "write `material`"),
    "density_absent": ("material.density", DELETE, "", "name", "required", "add `density`"),
    "density_zero": ("material.density", 0, "", "0", "above 0", "kg/m3"),
    "density_negative": ("material.density", -1.0, "", "-1.0", "above 0", "kg/m3"),
    "density_text": ("material.density", "1000", "", "'1000'", "a number", "write `density`"),
    "density_null": ("material.density", None, "", "null", "a number", "write `density`"),
    "density_true": ("material.density", True, "", "True", "a number", "write `density`"),
    "density_nan": ("material.density", float("nan"), "", "nan", "finite", "kg/m3"),
    "density_huge": ("material.density", 10**400, "", "inf", "finite", "kg/m3"),
    "density_in_g_per_cm3": ("material.density", 1.03, ": material", "1.48e+03 J/m3/K", "5000 to",
                             "g/cm3"),
    "capacity_in_calories": ("material.heat_capacity", 0.344, ": material", "354 J/m3/K", "foam",
                             "J/g/K"),
    "capacity_of_a_kmol": ("material.heat_capacity", 1e5, ": material", "1.03e+08", "5e+07 J/m3/K",
                           "J/kg/K"),
    "capacity_zero": ("material.heat_capacity", 0.0, "", "0.0", "above 0", "J/kg/K"),
    "capacity_negative": ("material.heat_capacity", -3, "", "-3", "above 0", "J/kg/K"),
    "capacity_table_key": ("material.heat_capacity", {"temperature": [300, 400]},
                           "material.heat_capacity.value", "temperature", "required",
                           "add `value`"),
    "capacity_table_text": ("material.heat_capacity", {"temperature": [300, 400], "value": "1"},
                            "material.heat_capacity.value", "1", "a list", "write `value`"),
    "conductivity_table_celsius": ("material.conductivity",
                                   {"temperature": [20, 100], "value": [0.1, 0.2]},
                                   "material.conductivity.temperature", "20", KELVIN, "add 273.15"),
    "conductivity_table_falls": ("material.conductivity",
                                 {"temperature": [400, 300], "value": [0.1, 0.2]},
                                 "material.conductivity.temperature", "[400.0, 300.0]",
                                 "each above the one before", "sort the table"),
    "capacity_text": ("material.heat_capacity", "1300 at 280 K", "", "1300 at 280 K",
                      'a number, or as {"temperature"', "write `heat_capacity`"),
    "conductivity_pairs": ("material.conductivity", [[280, 1300], [300, 1400]], "", "[[280, 1300]",
                           'a number, or as {"temperature"', "write `conductivity`"),
    "table_beyond": ("material.heat_capacity", {"temperature": [500, 600], "value": [1e3, 2e3]},
                     "material.heat_capacity.temperature", " K", "500 to 600 K",
                     "repeat its last value"),
    "conductivity_zero": ("material.conductivity", 0, "", "0", "above 0", "W/m/K"),
    "conductivity_negative": ("material.conductivity", -0.2, "", "-0.2", "above 0", "W/m/K"),
    "conductivity_null": ("unknown", ["convection"], "material.conductivity", "[convection]",
                          NULL, "add `conductivity`"),
    "material_key": ("material.rho", 3, "", "3", "known keys: density", "remove"),
    "exchange_absent": ("surface_exchange", DELETE, "", "format", "required", "add"),
    "convection_absent": ("surface_exchange.convection", DELETE, "", "emissivity", "required",
                          "add `convection`"),
    "convection_negative": ("surface_exchange.convection", -1, "", "-1", "at least 0", "W/m2/K"),
    "convection_infinite": ("surface_exchange.convection", float("inf"), "", "inf", "finite",
                            "W/m2/K"),
    "emissivity_above": ("surface_exchange.emissivity", 92, "", "92", "at most 1", "per cent"),
    "emissivity_negative": ("surface_exchange.emissivity", -0.1, "", "-0.1", "at least 0",
                            "fraction"),
    "emissivity_null": ("surface_exchange.emissivity", None, "", "null", NULL, "add `emissivity`"),
    "unknown_text": ("unknown", "conductivity", "", "'conductivity'", "a list", "write `unknown`"),
    "unknown_name": ("unknown", ["conductivty"], "", "'conductivty'", "diffusivity", "one of"),
    "unknown_number": ("unknown", [["a"]], "", "['a']", "diffusivity", "a list of names"),
    "unknown_twice": ("unknown", ["conductivity"] * 2, "", "conductivity, conductivity", "once",
                      "remove"),
    "scale_negative": ("scale_deviation", -0.01, "", "-0.01", "at least 0", "fraction"),
    "scale_per_cent": ("scale_deviation", 1, "", "1", "at most 0.5", "0.01 for 1 %"),
    "scale_nan": ("scale_deviation", float("nan"), "", "nan", "at least 0", "fraction"),
    "scale_text": ("scale_deviation", "1 %", "", "'1 %'", "a number", "write `scale_deviation`"),
    "prior_name": ("prior.density_relative_sd", 0.1, "", "0.1", "convection_relative_sd",
                   "did you mean"),
    "prior_zero": ("prior.convection_relative_sd", 0, "prior.convection", "0", "above 0",
                   "fraction"),
    "runs_absent": ("runs", DELETE, "", "format", "required", "add `runs`"),
    "runs_empty": ("runs", {}, "", "empty", "at least one run", "add a run"),
    "runs_list": ("runs", [], "", "[]", "an object", "write `runs`"),
    "run_null": (LAMP, None, "", "null", "an object", "write `lamp`"),
    "run_name": ("runs.a/b", {}, "", "a/b", "letters, digits", "rename"),
    "run_key": (f"{LAMP}.emissivity", 0.9, "", "0.9", "known keys: recording", "remove"),
    "recording_absent": (f"{LAMP}.recording", DELETE, "", "heater", "required", "add `recording`"),
    "recording_no_file": (f"{LAMP}.recording", "no.npz", "no.npz", "no such file", "existing",
                          "relative to its folder"),
    "recording_number": (f"{LAMP}.recording", 1, "", "1", "a text", "write `recording`"),
    "initial_celsius": (f"{LAMP}.initial_temperature", 22.0, "", "22.0", KELVIN, "273.15"),
    "ambient_hot": (f"{LAMP}.ambient_temperature", 29515, "", "29515", KELVIN, "kelvin"),
    "radiation_nan": (f"{LAMP}.radiation_temperature", float("nan"), "", "nan", KELVIN, "kelvin"),
    "radiation_null": (f"{LAMP}.radiation_temperature", None, "", "null", "a number", "write"),
    "ambient_absent": (f"{LAMP}.ambient_temperature", DELETE, "", "recording", "required", "add"),
    "held_out_text": (f"{LAMP}.held_out", "true", "", "'true'", "true or false", "write"),
    "heater_number": (HEATER, 5, "", "5", "an object", "write `heater`"),
    "heater_key": (f"{HEATER}.watts", 5, "", "5", "known keys: centre", "remove"),
    "heater_kind": (f"{HEATER}.kind", "laser", "", "'laser'", "spot", "write `kind`"),
    "centre_short": (f"{HEATER}.centre", [0, 0], "", "[0.0, 0.0]", "three finite", "x, y and z"),
    "centre_nan": (f"{HEATER}.centre", [0, 0, float("nan")], "", "nan", "three finite", "metres"),
    "centre_text": (f"{HEATER}.centre", "above", "", "'above'", "a list", "write `centre`"),
    "centre_ragged": (f"{HEATER}.centre", [[0], 0, 1], "", "[[0], 0, 1]", "numbers", "equal"),
    "direction_zero": (f"{HEATER}.direction", [0, 0, 0], "", "[0.0, 0.0, 0.0]", "other than zero",
                       "[0, 0, -1]"),
    "radius_zero": (f"{HEATER}.radius", 0, "", "0", "above 0", "metres"),
    "radius_negative": (f"{HEATER}.radius", -0.01, "", "-0.01", "above 0", "metres"),
    "power_negative": (f"{HEATER}.power", -2, "", "-2", "above 0", "watts"),
    "power_zero": (f"{HEATER}.power", 0, "", "0", "above 0", "null"),
    "power_absent": (f"{HEATER}.power", DELETE, "", "kind", "required", "add `power`"),
    "until_negative": (f"{HEATER}.until", -1, "", "-1", "above 0", "seconds"),
    "until_zero": (f"{HEATER}.until", 0, "", "0", "above 0", "null"),
    "rise_negative": (f"{HEATER}.rise", -1, "", "-1", "at least 0", "seconds"),
    "course_key": (f"{HEATER}.course.power", 5, "", "5", "known keys: time, share", "remove"),
    "course_list": (f"{HEATER}.course", [1], "", "[1]", "an object", "write `course`"),
    "course_short": (f"{HEATER}.course.share", [1.0], "", "shape (1,)", "(2,)", "as many"),
    "course_negative": (f"{HEATER}.course.share", [1.0, -0.1], "", "-0.1 to 1", "at least 0",
                        "logged"),
    "course_per_cent": (f"{HEATER}.course.share", [90, 100], "", "90 to 100", "at most 10",
                        "not per cent"),
    "course_late": (f"{HEATER}.course.time", [30.0, 40.0], "", "30 s", "below 30 s", "while"),
    "course_dark": (f"{HEATER}.course.share", [0, 0.0], "", "0 to 0", "above 0", "null"),
    "course_after": (f"{HEATER}.course", {"time": [0, 5, 6], "share": [0, 0, 1]},
                     "heater.course.time", "5 s", "below 2 s, the last frame", "null"),
    "course_nan": (f"{HEATER}.course.share", [1.0, float("nan")], "", "nan", "finite", "logged"),
    "course_back": (f"{HEATER}.course.time", [3, 1], "", "then 1 s", "increasing", "sort"),
    "constant_error_negative": (f"{LAMP}.constant_error", -0.1, "", "-0.1", "at least 0", "kelvin"),
    "constant_error_large": (f"{LAMP}.constant_error", 200, "", "200", "at most 20", "kelvin"),
    "constant_error_text": (f"{LAMP}.constant_error", "0.3", "", "'0.3'", "a number", "write"),
    "insulated_object": (f"{LAMP}.insulated", {}, "", "{}", "a list", "write `insulated`"),
    "insulated_number": (f"{LAMP}.insulated", [3], "insulated[0]", "3", "a list", "write"),
    "insulated_one_corner": (f"{LAMP}.insulated", [[[0, 0, 0]]], "insulated[0]", "[[0, 0, 0]]",
                             "two corners", "write"),
    "insulated_inside_out": (f"{LAMP}.insulated", [[[1, 0, 0], [0, 1, 1]]], "insulated[0]",
                             "[1.0, 0.0", "lower corner", "smallest"),
    "insulated_flat": (f"{LAMP}.insulated", [[[1, 0], [0, 1]]], "insulated[0]", "[1.0, 0.0]",
                       "three finite", "metres"),
    "air_object": (f"{LAMP}.air", {}, "", "{}", "a list", "write `air`"),
    "air_key": (f"{AIR}.warmth", 3, "air[0]", "3", "known keys: box, convection", "remove"),
    "air_box": (f"{AIR}.box", [[1, 0, 0], [0, 1, 1]], "air[0].box", "[1.0, 0.0",
                "lower corner", "smallest"),
    "air_negative": (f"{AIR}.convection", -4, "air[0].convection", "-4", "at least 0", "W/m2/K"),
    "air_celsius": (f"{AIR}.temperature", 30, "air[0].temperature", "30", "least 150", "kelvin"),
    "prescribed_object": (f"{LAMP}.prescribed", {}, "", "{}", "a list", "write"),
    "prescribed_number": (f"{LAMP}.prescribed", [4], "prescribed[0]", "4", "an object", "write"),
    "box_one_corner": (f"{HISTORY}.box", [[0, 0, 0]], "prescribed[0].box", "[[0, 0, 0]]",
                       "two corners", "write `box`"),
    "box_inside_out": (f"{HISTORY}.box", [[1, 0, 0], [0, 1, 1]], "prescribed[0].box", "[1.0, 0.0",
                       "lower corner", "smallest"),
    "box_flat": (f"{HISTORY}.box", [[1, 0], [0, 1]], "prescribed[0].box", "[1.0, 0.0]",
                 "three finite", "metres"),
    "history_celsius": (f"{HISTORY}.temperature", [20, 21, 22], "prescribed[0].temperature",
                        "3 of 3", "kelvin", "273.15"),
    "history_gap": (f"{HISTORY}.temperature", [295.0, float("nan"), 295.0],
                    "prescribed[0].temperature", "1 missing", "none missing", "leave out"),
    "history_null": (f"{HISTORY}.temperature", [295.0, None, 295.0], "prescribed[0].temperature",
                     "None", "numbers", "no nulls"),
    "history_short": (f"{HISTORY}.temperature", [295.0], "prescribed[0].temperature",
                      "shape (1,)", "(3,)", "as many"),
    "history_back": (f"{HISTORY}.time", [0, 2, 1], "prescribed[0].time", "then 1 s", "increasing",
                     "sort"),
    "history_ends_early": (f"{HISTORY}.time", [0, 0.5, 1.5], "prescribed[0].time", "0 to 1.5 s",
                           "0 to 2 s", "longer history"),
    "history_no_file": (f"{LAMP}.prescribed.1.history", "no.csv", "no.csv", "no such file",
                        "existing", "relative"),
    "history_and_values": (f"{LAMP}.prescribed.1.time", [0, 1], "prescribed[1].time", "[0, 1]",
                           "known keys: box, history", "remove"),
    "history_neither": (f"{HISTORY}.time", DELETE, "prescribed[0].time", "box, temperature",
                        "required", "add `time`"),
}  # fmt: skip


def changed(table: dict[str, Any], dotted: str, value: Any) -> None:
    """Set or delete the entry under a dotted key."""
    *path, last = dotted.split(".")
    target: Any = table
    for part in path:
        target = target[int(part)] if isinstance(target, list) else target[part]
    if value is DELETE:
        del target[last]
    else:
        target[last] = value


@pytest.mark.parametrize("case", BAD)
def test_bad_scene_is_refused(case, folder: Path, stated: dict, refuses) -> None:
    key, entry, where, value, limit, remedy = BAD[case]
    changed(stated, key, entry)
    (folder / "scene.json").write_text(json.dumps(stated))
    error = refuses(
        lambda: read_scene(folder), where=where or key, value=value, limit=limit, remedy=remedy
    )
    assert str(folder) in error.where


@pytest.mark.parametrize(
    ("text", "value", "limit", "remedy"),
    [
        ("", "Expecting value", "JSON in UTF-8", "correct"),
        ('{"format": ', "Expecting value", "JSON in UTF-8", "correct"),
        ("[" * 100_000, "RecursionError", "JSON in UTF-8", "correct"),
        ("\udcff", "UnicodeDecodeError", "JSON in UTF-8", "correct"),
        ("[1, 2]", "[1, 2]", "an object", "write"),
        ("null", "null", "an object", "write"),
        ('{"unit": "m", "unit": "mm"}', "unit", "once", "remove"),
    ],
)
def test_broken_json_is_refused(text, value, limit, remedy, folder: Path, refuses) -> None:
    (folder / "scene.json").write_bytes(text.encode("utf-8", errors="surrogateescape"))
    refuses(
        lambda: read_scene(folder), where=str(folder / "scene.json"), value=value, limit=limit,
        remedy=remedy,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["", "absent"])
def test_folder_without_scene_is_refused(name, tmp_path: Path, refuses) -> None:
    refuses(
        lambda: read_scene(tmp_path / name), where="scene.json", value="no such file",
        limit="existing", remedy="check the name",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "value", "limit"),
    [
        ("time,pressure\n0,300\n", "time, pressure", "time and temperature"),
        ("time,temperature\n0,\n", "''", "a number"),
    ],
)
def test_bad_history_file_is_refused(text, value, limit, folder: Path, refuses) -> None:
    (folder / "end.csv").write_text(text)
    refuses(lambda: read_scene(folder), where="end.csv", value=value, limit=limit, remedy="")


def test_truncated_recording_of_a_scene_is_refused(folder: Path, refuses) -> None:
    whole = (folder / "cooling.npz").read_bytes()
    (folder / "cooling.npz").write_bytes(whole[: len(whole) // 2])
    refuses(
        lambda: read_scene(folder), where=str(folder / "cooling.npz"),
        value=f"{len(whole) // 2} bytes", limit="zip", remedy="truncated",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("quiet", "fine"),
    [(343.0, True), (324.0, True), (295.0, False), (363.5, False), (np.nan, True)],
)
def test_quiet_frames_of_a_body_that_is_not_at_its_start_are_refused(
    folder: Path, quiet: float, fine: bool, refuses
) -> None:
    # The run spans 40 K: half of that, and no more, may be a camera's constant error.
    with np.load(folder / "cooling.npz") as file:
        parts = dict(file)
    frames, samples = parts["temperature"].shape
    parts["temperature"] = np.tile(np.linspace(343.0, 303.0, frames)[:, None], samples)
    np.savez(folder / "cooling.npz", **parts | {"quiet": np.full((4, samples), quiet)})
    table = json.loads((folder / "scene.json").read_text())
    table["runs"]["cooling"]["initial_temperature"] = 343.0
    (folder / "scene.json").write_text(json.dumps(table))
    if fine:
        assert read_scene(folder).runs["cooling"].initial_temperature == 343.0
        return
    refuses(
        lambda: read_scene(folder), where="runs.cooling.initial_temperature",
        value=f"mean is {quiet:g} K", limit="20 K apart", remedy="t = 0",
    )  # fmt: skip


@pytest.mark.parametrize(("shift", "fine"), [(0.0, True), (149.0, True), (273.15, False)])
@pytest.mark.parametrize("begin", [0.0, 0.5])
def test_a_first_frame_of_another_scale_is_refused(
    folder: Path, shift: float, fine: bool, begin: float, refuses
) -> None:
    with np.load(folder / "cooling.npz") as file:
        parts = {name: value for name, value in file.items() if name != "quiet"}
    frames, samples = parts["temperature"].shape
    cooling = np.tile(np.linspace(343.0, 303.0, frames)[:, None], samples)
    parts |= {"temperature": cooling + shift, "time": parts["time"] - parts["time"][0] + begin}
    np.savez(folder / "cooling.npz", **parts)
    table = json.loads((folder / "scene.json").read_text())
    table["runs"]["cooling"]["initial_temperature"] = 343.0
    (folder / "scene.json").write_text(json.dumps(table))
    if fine or begin > 0:
        assert read_scene(folder).runs["cooling"].initial_temperature == 343.0
        return
    refuses(
        lambda: read_scene(folder), where="runs.cooling.initial_temperature",
        value="343 K; there the mean is 616.15 K", limit="150 K apart",
        remedy="unit of the readings",
    )  # fmt: skip


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=5,
)


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_any_value_anywhere_is_read_or_refused(data: st.DataObject, sound: dict) -> None:
    key = data.draw(st.sampled_from(sorted({entry[0] for entry in BAD.values()})))
    table = json.loads(json.dumps(sound["table"]))
    changed(table, key, data.draw(JSON))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, content in sound["files"].items():
            (folder / path).write_bytes(content)
        (folder / "scene.json").write_text(json.dumps(table))
        try:
            read_scene(folder)
        except InputError as error:
            assert name in error.where
            assert len(str(error).splitlines()) == 4


@pytest.fixture(scope="module")
def sound() -> dict[str, Any]:
    """Return the entries and the files of a sound scene folder."""
    import io

    stream = io.BytesIO()
    np.savez(
        stream, points=np.eye(3), time=np.array([0.0, 1.0, 2.0]), temperature=np.full((3, 3), 300.0)
    )
    files = {
        "surface.off": b"OFF\n", "end.csv": b"time,temperature\n0,300\n60,300\n",
        "lamp.npz": stream.getvalue(),
    }  # fmt: skip
    run = {
        "recording": "lamp.npz", "initial_temperature": 295.0, "ambient_temperature": 295.0,
        "radiation_temperature": 295.0, "held_out": False,
        "heater": {"kind": "spot", "centre": [0, 0, 1], "direction": [0, 0, -1], "radius": 0.1,
                   "power": 1, "until": 1, "rise": 0,
                   "course": {"time": [0, 60], "share": [0.9, 1.0]}},
        "insulated": [[[0, 0, 0], [1, 1, 1]]],
        "air": [{"box": [[0, 0, 0], [1, 1, 1]], "convection": 4, "temperature": 300}],
        "prescribed": [
            {"box": [[0, 0, 0], [1, 1, 1]], "time": [0, 60], "temperature": [300, 301]},
            {"box": [[0, 0, 0], [1, 1, 1]], "history": "end.csv"},
        ],
    }  # fmt: skip
    table = {
        "format": "thermofield-scene/1", "surface": "surface.off",
        "material": {"density": 1e3, "heat_capacity": 1e3, "conductivity": None},
        "surface_exchange": {"convection": 1.0, "emissivity": 0.5},
        "unknown": ["conductivity"], "prior": {}, "runs": {"lamp": run},
    }  # fmt: skip
    return {"table": table, "files": files}

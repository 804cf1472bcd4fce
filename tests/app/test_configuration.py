"""Only what stands in the tables can be built, and from sensible settings only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given as sampled
from hypothesis import strategies as st
from omegaconf import OmegaConf

from thermo.app import _configuration as configuration
from thermo.app._command import configuration_folder
from thermo.errors import InputError
from thermo.inverse import Adam, LevenbergMarquardt, Meshing, Network, Prior, Stepping
from thermo.physics.integrators import BackwardEuler, Sdirk2

CONF = configuration_folder()
BUILDERS = {
    "field": (configuration.build_field, configuration.FIELDS),
    "optimiser": (configuration.build_optimiser, configuration.OPTIMISERS),
    "integrator": (configuration.build_stepping, configuration.INTEGRATORS),
}


def section(group: str, name: str) -> dict[str, Any]:
    found = OmegaConf.to_container(OmegaConf.load(CONF / group / f"{name}.yaml"))
    assert isinstance(found, dict)
    return {str(key): value for key, value in found.items()}


@pytest.mark.parametrize("group", list(BUILDERS))
def test_every_file_builds_what_its_name_says_and_every_name_has_a_file(group: str) -> None:
    build, table = BUILDERS[group]
    files = {path.stem for path in (CONF / group).glob("*.yaml")}
    presets = {name for name in files if name.startswith("paper_")}
    assert files - presets == set(table)
    for name in presets:
        made = build(section(group, name))
        assert type(made) is table[name.removeprefix("paper_")]
    for name, kind in table.items():
        made = build(section(group, name))
        assert type(made.integrator if group == "integrator" else made) is kind


def test_the_defaults_of_the_files_are_those_of_the_package() -> None:
    assert configuration.build_optimiser(section("optimiser", "lm")) == LevenbergMarquardt()
    assert configuration.build_optimiser(section("optimiser", "adam")) == Adam()
    assert configuration.build_field(section("field", "network")) == Network()
    assert configuration.build_meshing(section("mesh", "tet10")) == Meshing()
    assert configuration.build_meshing(section("mesh", "tet4")) == Meshing(order=1)
    assert configuration.build_prior(section("prior", "smooth")) == Prior()
    stepping = configuration.build_stepping(section("integrator", "sdirk2"))
    assert stepping == Stepping(integrator=Sdirk2())
    paper = configuration.build_stepping(section("integrator", "backward_euler"))
    assert paper == Stepping(integrator=BackwardEuler(), lagged=True)


def test_the_cache_becomes_a_path() -> None:
    made = configuration.build_meshing({**section("mesh", "tet4"), "cache": "some/where"})
    assert made.cache == Path("some/where")


@pytest.mark.parametrize("group", list(BUILDERS))
@pytest.mark.parametrize(
    "kind", ["nope", None, "os.system", "thermo.inverse.Adam", "__class__", 3, ["lm"]]
)
def test_kinds_outside_the_tables_are_refused(group: str, kind: Any) -> None:
    build, table = BUILDERS[group]
    with pytest.raises(InputError, match=f"there is no such {group}") as caught:
        build({"kind": kind})
    assert caught.value.where == f"{group}.kind" and caught.value.limit == ", ".join(table)


@pytest.mark.parametrize("group", list(BUILDERS))
@pytest.mark.parametrize("key", ["_target_", "_partial_", "_args_", "bogus"])
def test_a_target_cannot_be_smuggled_in(group: str, key: str) -> None:
    build, table = BUILDERS[group]
    with pytest.raises(InputError, match="unknown setting") as caught:
        build({"kind": next(iter(table)), key: "os.system"})
    assert caught.value.where == f"{group}.{key}"


@sampled(
    st.one_of(
        st.integers(max_value=0), st.floats(max_value=0.0), st.text(), st.none(), st.booleans(),
        st.just(float("nan")), st.just(float("inf")), st.just(2.5), st.lists(st.integers()),
    )
)  # fmt: skip
def test_a_number_of_steps_is_whole_and_positive(value: Any) -> None:
    with pytest.raises(InputError) as caught:
        configuration.build_optimiser({"kind": "lm", "max_steps": value})
    assert caught.value.where == "optimiser.max_steps" and caught.value.remedy


@pytest.mark.parametrize(
    ("group", "values"),
    [
        ("optimiser", {"kind": "adam", "rate": 0.0}),
        ("optimiser", {"kind": "adam", "rates": {"conductivity": "fast"}}),
        ("field", {"kind": "network", "linear": 1}),
        ("field", {"kind": "patchwise", "patches": -1}),
        ("integrator", {"kind": "sdirk2", "tolerance": "small"}),
    ],
)
def test_settings_that_make_no_sense_are_refused(group: str, values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="makes no sense") as caught:
        BUILDERS[group][0](values)
    assert caught.value.where == f"{group}.{list(values)[-1]}"


@pytest.mark.parametrize(
    ("key", "limit"), [("order", "1 or 2"), ("coarse_tangents", "True or False")]
)
@pytest.mark.parametrize("value", [-1, 3, "2"])
def test_meshing_takes_one_of_its_choices(key: str, limit: str, value: Any) -> None:
    with pytest.raises(InputError) as caught:
        configuration.build_meshing({**section("mesh", "tet10"), key: value})
    assert caught.value.limit == limit and caught.value.value == value


def test_a_network_may_do_without_octaves() -> None:
    assert configuration.build_field({"kind": "network", "octaves": 0}).octaves == 0


@pytest.mark.parametrize("values", [{"step": 0.0, "decay": 0.0}, {"step": 1.0, "decay": -1.0}])
def test_a_prior_that_makes_no_sense_is_refused(values: dict[str, float]) -> None:
    with pytest.raises(InputError, match="prior"):
        configuration.build_prior(values)


def test_lists_of_names() -> None:
    assert configuration.names(None, "runs") is None
    assert configuration.names(["a", "b"], "runs") == ("a", "b")
    for wrong, meant in (("a", "a"), (["a", 1], "a,b"), (3, "a,b")):
        with pytest.raises(InputError) as caught:
            configuration.names(wrong, "runs")
        assert caught.value.where == "runs" and f"runs=[{meant}]" in caught.value.remedy


def test_values_that_are_given() -> None:
    assert configuration.given({"a": None, "b": 2}, "x.") == {"b": 2.0}
    with pytest.raises(InputError) as caught:
        configuration.given({"b": "two"}, "x.")
    assert caught.value.where == "x.b"


def test_stages_are_those_of_the_files() -> None:
    assert {path.stem for path in (CONF / "stages").glob("*.yaml")} == set(configuration.STAGES)
    for name in configuration.STAGES:
        assert configuration.stages(section("stages", name)) == name
    with pytest.raises(InputError, match="no such stages"):
        configuration.stages({"kind": "tet10_tet4"})

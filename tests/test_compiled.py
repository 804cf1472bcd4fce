"""Compiled programs on disk: kept by default, where the user says, or not at all."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo import _compiled

SCRIPT = """
import jax, jax.numpy as jnp
import thermo
from thermo.mesh import box_mesh
from thermo.physics import Model, discretise, solve_heat, uniform_steps
from thermo.physics.integrators import Sdirk2
import equinox as eqx, numpy as np
space = discretise(box_mesh((0.02, 0.02, 0.01), (3, 3, 2)))
cells = len(space.mesh.cells)
model = Model(space, jnp.full(cells, 1.0), jnp.full(cells, 1e6))
start = jnp.full(len(space.mesh.nodes), 300.0)
eqx.filter_jit(solve_heat)(model, start, uniform_steps(np.array([1.0]), 0.5), integrator=Sdirk2())
print(jax.config.jax_compilation_cache_dir)
"""


def run(home: Path, **environment: str) -> str:
    """The folder that the process kept its programs in, as it says."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "XDG_"))}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**kept, "XDG_CACHE_HOME": str(home), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_programs_are_kept_in_the_users_cache(tmp_path: Path) -> None:
    folder = Path(run(tmp_path))
    assert folder.parent == tmp_path / "thermofield" / "compiled"
    assert any(folder.iterdir())


def test_an_import_makes_no_folder(tmp_path: Path) -> None:
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-c", "import thermo"], env=environment, check=True)
    assert not (tmp_path / "thermofield").exists()


def test_the_users_own_folder_counts(tmp_path: Path) -> None:
    chosen = tmp_path / "mine"
    assert run(tmp_path, JAX_COMPILATION_CACHE_DIR=str(chosen)) == str(chosen)
    assert not (tmp_path / "thermofield").exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_folder_that_cannot_be_written_is_passed_over(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    assert run(tmp_path) == "None"


def test_a_file_in_the_way_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "thermofield").write_text("")
    assert run(tmp_path) == "None"


def test_programs_are_dropped_near_the_limit_of_memory_maps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    dropped: list[bool] = []
    monkeypatch.setattr(_compiled.jax, "clear_caches", lambda: dropped.append(True))
    # What is dropped is compiled again, by one thread again.
    _compiled.program(jnp.cos)(jnp.zeros(()))
    monkeypatch.setattr(_compiled, "MOST_MAPS", 1.0)
    _compiled.make_room()
    assert not dropped and _compiled._turns
    monkeypatch.setattr(_compiled, "MOST_MAPS", 0.0)
    _compiled.make_room()
    assert dropped == ([True] if sys.platform == "linux" else [])
    assert not (dropped and _compiled._turns)


def test_a_program_is_what_its_function_is_and_is_compiled_once() -> None:
    traced = []

    def double(numbers: jax.Array, *, more: str) -> jax.Array:
        traced.append(more)
        return 2 * numbers

    first = _compiled.program(double)(jnp.arange(3.0), more="once")
    again = _compiled.program(double)(jnp.arange(3.0) + 1, more="once")
    np.testing.assert_array_equal(first, [0, 2, 4])
    np.testing.assert_array_equal(again, [2, 4, 6])
    assert traced == ["once"]
    assert _compiled.program(double).__name__ == "double"


def test_numbers_of_weak_type_ask_for_no_program_of_their_own() -> None:
    traced, asked = [], []

    def double(number: jax.Array) -> jax.Array:
        traced.append(number)
        return 2 * number

    def options() -> dict[str, Any]:
        asked.append("once")
        return {}

    run = _compiled.program(double, options)
    weak, strong = jnp.asarray(3.0), jnp.zeros(())
    assert weak.weak_type and not strong.weak_type
    assert run(weak) == 6 and run(strong) == 0 and run(number=weak) == 6
    assert len(traced) == 1 and asked == ["once"]


def test_threads_that_need_one_program_at_once_compile_it_once() -> None:
    traced = []

    def slow(numbers: jax.Array) -> jax.Array:
        traced.append(len(numbers))
        time.sleep(0.2)  # as long as another thread needs to come here as well
        return 2 * numbers

    run = _compiled.program(slow)
    with ThreadPoolExecutor(4) as pool:
        done = list(pool.map(run, [jnp.arange(3.0), jnp.ones(3), jnp.arange(4.0), jnp.ones(4)]))
    np.testing.assert_array_equal(done[0], [0, 2, 4])
    np.testing.assert_array_equal(done[3], [2, 2, 2, 2])
    assert sorted(traced) == [3, 4]


def test_a_program_that_failed_is_tried_again() -> None:
    calls = []

    def fails_once(numbers: jax.Array) -> jax.Array:
        calls.append(True)
        if len(calls) == 1:
            raise ValueError("not yet")
        return numbers

    run = _compiled.program(fails_once)
    with pytest.raises(ValueError, match="not yet"):
        run(jnp.zeros(2))
    np.testing.assert_array_equal(run(jnp.zeros(2)), [0, 0])


def test_where_the_compiler_knows_no_such_option_it_does_without(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(_compiled, "_OPTIONS", {"xla_no_such_option": True})
    _compiled._options.cache_clear()
    try:
        assert _compiled._options() == {}
        assert float(_compiled.program(jnp.sin)(jnp.zeros(()))) == 0.0
    finally:
        _compiled._options.cache_clear()

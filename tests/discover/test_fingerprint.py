"""What changes a calculation changes its fingerprint, and nothing else does."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover import Place
from thermo.discover._fingerprint import fingerprint
from thermo.discover.candidates import HiddenSource, LocalConvection

from .lit_objective import objective

NUMBERS = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=4)
PLACE = Place(jnp.zeros((2, 3)), jnp.ones(2))


@given(NUMBERS, st.integers(0, 3))
def test_one_bit_of_one_number_counts(values: list[float], at: int) -> None:
    mine = np.array(values)
    other = mine.copy()
    other[at % len(other)] = np.nextafter(other[at % len(other)], np.inf)
    assert fingerprint(mine) == fingerprint(mine.copy()) == fingerprint(jnp.asarray(mine))
    assert fingerprint(mine) != fingerprint(other)


def test_kinds_names_and_shapes_count() -> None:
    source = HiddenSource(jnp.zeros(2), PLACE)
    others = (
        source, LocalConvection(jnp.zeros(2), PLACE), replace(source, strength=jnp.ones(2)),
        replace(source, place=replace(PLACE, size=2 * jnp.ones(2))), [source], (source, source),
        {"a": source}, {"b": source},
        np.zeros(2), np.zeros((1, 2)), np.zeros(2, np.float32), [0.0, 0.0], [0, 0], "0", b"0", 0,
        None, fingerprint, HiddenSource,
    )  # fmt: skip
    assert len({fingerprint(one) for one in others}) == len(others)
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})
    assert fingerprint(np.arange(6.0).reshape(2, 3).T) == fingerprint(
        np.ascontiguousarray(np.arange(6.0).reshape(2, 3).T)
    )


def test_another_process_finds_the_same() -> None:
    words = (
        "from lit_objective import objective; from thermo.discover._fingerprint import fingerprint;"
        "print(fingerprint(objective(), len))"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    # Sets and texts of addresses differ from process to process.
    told = subprocess.run(
        [sys.executable, "-c", words], capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "7"},
    )  # fmt: skip
    assert told.stdout.strip() == fingerprint(objective(), len)

from __future__ import annotations

import json
from pathlib import Path

import hypothesis.strategies as st
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

from thermo.report import write_json

LEAVES = st.none() | st.booleans() | st.integers() | st.text() | st.floats(allow_nan=False)
TREES = st.recursive(
    LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner)
)


def no_infinity(value: object) -> object:
    if isinstance(value, float) and abs(value) == float("inf"):
        return None
    if isinstance(value, list):
        return [no_infinity(v) for v in value]
    if isinstance(value, dict):
        return {k: no_infinity(v) for k, v in value.items()}
    return value


@given(st.dictionaries(st.text(), TREES))
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, data: dict) -> None:
    path = tmp_path_factory.mktemp("json") / "result.json"
    write_json(path, data)
    text = path.read_text("utf-8")
    assert text.endswith("}\n")
    assert json.loads(text) == no_infinity(data)


def test_numpy_and_jax_become_plain(tmp_path: Path) -> None:
    path = tmp_path / "new" / "result.json"
    data = {
        "float32": np.float32(0.5),
        "int": np.int64(3),
        "bool": np.bool_(True),
        "array": np.array([[1.0, np.nan], [np.inf, -2.0]]),
        "jax": jnp.arange(3),
        "scalar": jnp.asarray(1.5),
        "path": Path("a") / "b",
        "tuple": (1, 2),
    }
    write_json(path, data)
    assert json.loads(path.read_text()) == {
        "float32": 0.5,
        "int": 3,
        "bool": True,
        "array": [[1.0, None], [None, -2.0]],
        "jax": [0, 1, 2],
        "scalar": 1.5,
        "path": "a/b",
        "tuple": [1, 2],
    }
    assert "NaN" not in path.read_text()


@pytest.mark.parametrize("bad", [{1: 2}, object(), {"a", "b"}, np.array([object()]), 1j])
def test_what_json_cannot_hold_is_named_and_the_old_file_stands(
    tmp_path: Path, bad: object
) -> None:
    path = tmp_path / "result.json"
    write_json(path, {"old": 1})
    with pytest.raises(TypeError, match=r"data\.fields\.bad"):
        write_json(path, {"fields": {"bad": bad}})
    assert json.loads(path.read_text()) == {"old": 1}
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]

from __future__ import annotations

from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from thermo.report import write_npz


def test_round_trip_without_pickles(tmp_path: Path) -> None:
    path = tmp_path / "new" / "run.npz"
    points = np.random.default_rng(0).normal(size=(5, 3))
    write_npz(path, points=points, time=jnp.arange(3.0), name="k", valid=np.ones(2, bool))
    with np.load(path, allow_pickle=False) as found:
        assert set(found.files) == {"points", "time", "name", "valid"}
        np.testing.assert_array_equal(found["points"], points)
        np.testing.assert_array_equal(found["time"], [0.0, 1.0, 2.0])
        assert str(found["name"]) == "k" and found["valid"].dtype == bool


def test_the_name_is_kept_as_given(tmp_path: Path) -> None:
    write_npz(tmp_path / "state.checkpoint", a=np.zeros(2))
    assert [p.name for p in tmp_path.iterdir()] == ["state.checkpoint"]


def test_objects_are_refused_and_the_old_file_stands(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    write_npz(path, a=np.zeros(2))
    with pytest.raises(TypeError, match="bad"):
        write_npz(path, a=np.ones(2), bad=np.array([{}], dtype=object))
    with np.load(path, allow_pickle=False) as found:
        np.testing.assert_array_equal(found["a"], 0.0)
    assert list(tmp_path.iterdir()) == [path]

from __future__ import annotations

import platform

import jax
import numpy as np
import pytest

from thermo.report import _versions, versions


def test_what_is_installed() -> None:
    found = versions()
    assert found["python"] == platform.python_version()
    assert found["jax"] == jax.__version__
    assert found["numpy"] == np.__version__
    assert {"thermofield", "equinox", "lineax", "optimistix", "pytetwild"} <= set(found)


def test_what_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_versions, "_DISTRIBUTIONS", ("no-such-distribution",))
    assert versions()["no-such-distribution"] == "not installed"

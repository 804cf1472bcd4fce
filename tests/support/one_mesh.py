"""Simulations on the mesh that is asked for alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from thermo.inverse import _predict


def simulate_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the coarse mesh that only tells what cells make wrong: a second large program.

    What cells make wrong comes out as zero: not for tests that look at it.
    """

    def first(made: Callable[[float], Any], finer: tuple[float, float]) -> list[Any]:
        return [made(finer[0])] * len(finer)

    monkeypatch.setattr(_predict, "at_once", first)

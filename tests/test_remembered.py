"""What was worked out for the same arrays is not worked out again, and for others it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from thermo._remembered import forget, remembered
from thermo.mesh import Mesh, box_mesh
from thermo.physics import discretise

Seen = list[float]


@pytest.fixture
def seen() -> Seen:
    return []


@pytest.fixture
def total(seen: Seen) -> Callable[..., float]:
    @remembered(2)
    def total(values: np.ndarray, times: float = 1.0) -> float:
        seen.append(times)
        return times * float(values.sum())

    return total


def test_the_same_content_is_worked_out_once(total: Callable[..., float], seen: Seen) -> None:
    values = np.arange(4.0)
    assert total(values) == total(values.copy()) == total(np.arange(8.0)[:4]) == 6.0
    assert seen == [1.0]


@pytest.mark.parametrize(
    "others",
    [
        ((np.arange(4.0), 2.0), {}), ((np.arange(4.0),), {"times": 1.0}),
        ((np.arange(4.0) + 1e-15,), {}), ((np.arange(4.0).reshape(2, 2),), {}),
        ((np.arange(4),), {}), ((np.zeros(0),), {}),
    ],
)  # fmt: skip
def test_whatever_is_another_argument_is_worked_out(
    total: Callable[..., float], seen: Seen, others: tuple
) -> None:
    total(np.arange(4.0))
    args, named = others
    assert total(*args, **named) == named.get("times", (*args, 1.0)[1]) * args[0].sum()
    assert len(seen) == 2


def test_content_that_changed_in_place_is_another(total: Callable[..., float], seen: Seen) -> None:
    values = np.arange(4.0)
    total(values)
    values[0] = 10.0
    assert total(values) == 16.0 and len(seen) == 2


def test_what_was_asked_longest_ago_is_dropped(total: Callable[..., float], seen: Seen) -> None:
    for times in (1.0, 2.0, 1.0, 3.0, 1.0, 2.0):
        total(np.ones(1), times)
    assert seen == [1.0, 2.0, 3.0, 2.0]


def test_what_is_forgotten_is_worked_out_again(total: Callable[..., float], seen: Seen) -> None:
    for _ in range(2):
        total(np.ones(1))
        forget()
    assert seen == [1.0, 1.0]


def test_what_fails_is_not_kept(seen: Seen) -> None:
    @remembered(1)
    def fails(values: np.ndarray) -> float:
        seen.append(float(values[0]))
        raise ValueError(values)

    for _ in range(2):
        with pytest.raises(ValueError, match="1"):
            fails(np.ones(1))
    assert seen == [1.0, 1.0]


def test_a_mesh_is_prepared_once_whatever_the_reach() -> None:
    def made() -> Mesh:
        return box_mesh((0.02, 0.02, 0.02), (3, 3, 3))

    first, again = discretise(made()), discretise(made(), 1e-4)
    assert again.pattern is first.pattern
    assert discretise(box_mesh((0.02, 0.02, 0.021), (3, 3, 3))).pattern is not first.pattern

"""When a lamp begins to shine."""

from __future__ import annotations

import pytest

from thermo.observe import Course, Heater


@pytest.mark.parametrize(
    ("course", "begins"),
    [
        (None, 0.0),
        (Course([0.0, 5.0, 6.0], [0.0, 0.0, 1.0]), 5.0),
        (Course([2.0, 5.0], [0.5, 0.0]), 0.0),
        (Course([-3.0, -2.0], [0.0, 1.0]), 0.0),
    ],
)
def test_it_shines_from_the_last_dark_time_of_its_course(
    course: Course | None, begins: float
) -> None:
    lamp = Heater([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 0.01, 2.0, 30.0, course=course)
    assert lamp.first_light() == begins

"""The numbers of the paper, as they are printed."""

from __future__ import annotations

import math

from thermo.study import ROWS


def test_the_published_numbers_are_those_of_the_papers_table() -> None:
    # Sums over the table as it is printed: a wrong digit changes them.
    rows = list(ROWS.values())
    assert math.isclose(sum(row.error for row in rows), 3.224)
    assert math.isclose(sum(row.ratio for row in rows), 11.336)
    assert math.isclose(sum(row.width for row in rows), 9.819)

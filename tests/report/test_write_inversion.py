"""Numbers that the record of a fit makes of its runs."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.inverse import RunFit
from thermo.report._write_inversion import _at_the_end


def test_the_error_at_the_end_is_that_of_the_last_frame_with_readings() -> None:
    measured = np.array([[300.0, 300.0, 300.0], [301.0, 302.0, np.nan], [np.nan] * 3])
    simulated = np.array([[309.0, 309.0, 309.0], [301.5, 301.0, 350.0], [400.0] * 3])
    run = RunFit(1.0, 0.1, 0.1, np.arange(3.0), np.zeros((3, 3)), measured, simulated)
    assert _at_the_end(run) == pytest.approx(0.75)

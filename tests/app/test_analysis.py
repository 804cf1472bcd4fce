"""What an analysis allows for beside the noise."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.app._analysis import allowing
from thermo.inverse import DEFECT_LEFT, Sensitivity


@pytest.mark.parametrize(("corrected", "left"), [(True, DEFECT_LEFT), (False, 1.0)])
def test_a_corrected_fit_leaves_a_share_of_what_cells_and_steps_make_wrong(
    corrected: bool, left: float
) -> None:
    at = Sensitivity(("conductivity",), {"a": np.ones((5, 3, 1))}, {"a": 0.05}, values=(1.0,))
    # Measured over all frames of a longer run of the same kind.
    apart = np.random.default_rng(0).standard_normal((8, 3))
    made = allowing(at, {"a": apart}, corrected=corrected)
    assert np.allclose(made.defect["a"], left * apart[:5])

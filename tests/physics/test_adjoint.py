"""What cannot be kept for a reverse pass is refused; that both ways agree stands in gradients."""

from __future__ import annotations

import pytest

from thermo.errors import InputError
from thermo.physics import RecomputeSegments


@pytest.mark.parametrize("length", [0, -3])
def test_a_segment_has_steps(length: int) -> None:
    with pytest.raises(InputError, match="RecomputeSegments: length"):
        RecomputeSegments(length)

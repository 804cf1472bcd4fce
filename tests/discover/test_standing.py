"""What a standing leaves, and how much of it another one closes."""

from __future__ import annotations

import numpy as np
import pytest
from standings import standing

from thermo.discover import _standing
from thermo.discover._standing import fitted, share_closed


def test_what_is_left_is_never_less_than_noise() -> None:
    assert standing(50.0, 2, smooth=0.2).misfit() == 1.0
    assert standing(50.0, 2, smooth=7.0).misfit() == pytest.approx(7.0)


def test_the_share_closed_is_of_what_is_beyond_noise_and_one_at_the_most() -> None:
    before = standing(200.0, 2, smooth=101.0)
    assert share_closed(before, standing(100.0, 3, smooth=51.0)) == pytest.approx(0.5)
    assert share_closed(before, standing(40.0, 3, smooth=0.1)) == 1.0
    assert share_closed(before, before) == 0.0
    # A gap within the scatter of one square of noise is no measure: that scatter is.
    small = standing(60.0, 2, smooth=1.5)
    assert share_closed(small, standing(60.0, 3)) == pytest.approx(0.5 / np.sqrt(2))


def test_a_fit_makes_room_for_its_program(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without it a long search came to what the system allows a process, and was aborted.
    class AskedFor(Exception):
        pass

    def make_room() -> None:
        raise AskedFor

    monkeypatch.setattr(_standing, "make_room", make_room)
    with pytest.raises(AskedFor):
        fitted(standing(60.0, 2), times=0)

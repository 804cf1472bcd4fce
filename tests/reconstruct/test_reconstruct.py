"""From photographs to a closed surface, all in one call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coloured_ball import CENTRE, RADIUS, cameras, photograph

from thermo.reconstruct import Sampling, Training, _extract_surface, reconstruct, region_of


def test_a_ball_is_rebuilt_as_large_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The grid is coarse: it has no places to fill a chunk of the usual size with.
    monkeypatch.setattr(_extract_surface, "_CHUNK", 1 << 14)
    photographs = [photograph(camera) for camera in cameras(12)]
    training = Training(
        steps=200, rays=192, cells=(8, 16), width=32, rate=1e-2, sampling=Sampling(16, 1, 16)
    )
    told: list[int] = []
    file = tmp_path / "checkpoint.npz"
    found = reconstruct(
        photographs, region_of(photographs), training, triangles=600, checkpoint=file,
        on_step=lambda made, *_: told.append(made),
    )  # fmt: skip
    assert told[-1] == 200 and file.exists()
    assert len(found.trained.psnr) == 200
    surface = found.surface
    assert len(surface.triangles) <= 600
    assert surface.volume() == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.04)
    off = np.linalg.norm(surface.vertices - CENTRE, axis=1) - RADIUS
    assert np.abs(off).mean() < 0.02 * RADIUS
    # From the checkpoint nothing is trained again.
    again = reconstruct(photographs, region_of(photographs), training, checkpoint=file)
    assert len(again.surface.triangles) > 600
    assert again.surface.volume() == pytest.approx(surface.volume(), rel=0.01)

"""What bringing frames to a surface leaves beside the scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from thermo.imaging import Camera, SurfaceSamples
from thermo.report import write_registration

CAMERAS = [
    Camera(8, 6, [10.0, 10.0], [3.5, 2.5], np.eye(4), name=name)
    for name in ("left", "right", "blind")
]
SEEN = np.array([[True, True, True, False], [False, True, True, True], [False] * 4])
FOOTPRINT = np.where(SEEN, [[1e-3, 2e-3, 5e-3, 0], [0, 4e-4, 6e-4, 9e-4], [0] * 4], np.nan)
SAMPLES = SurfaceSamples(
    points=np.arange(12.0).reshape(4, 3),
    seen=SEEN,
    pixels=np.zeros((3, 4, 4), int),
    weights=np.full((3, 4, 4), 0.25),
    footprint=FOOTPRINT,
    cosine=np.where(SEEN, 0.8, np.nan),
)


def test_it_says_how_each_camera_read(tmp_path: Path) -> None:
    told = ["a pixel is dead", "a frame repeats"]
    record = write_registration(
        tmp_path / "new", "lamp", CAMERAS, SAMPLES, 0.625, told, {"run": "lamp"}
    )
    assert {path.name for path in (tmp_path / "new").iterdir()} == {
        "lamp+samples.npz", "lamp+registration.json",
    }  # fmt: skip
    text = (tmp_path / "new" / "lamp+registration.json").read_text("utf-8")
    assert json.loads(text) == record
    assert (record["samples"], record["coverage"], record["told"]) == (4, 0.625, told)
    assert record["configuration"] == {"run": "lamp"}
    # The median of what a camera sees; one that sees nothing has none.
    of = {name: (one["samples"], one["footprint"]) for name, one in record["cameras"].items()}
    assert of == {"left": (3, 2e-3), "right": (3, 6e-4), "blind": (0, None)}
    with np.load(tmp_path / "new" / "lamp+samples.npz", allow_pickle=False) as stored:
        assert sorted(stored) == ["cosine", "footprint", "points", "seen"]
        for name in stored:
            np.testing.assert_array_equal(stored[name], getattr(SAMPLES, name))

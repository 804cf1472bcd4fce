"""What is sent to Rerun."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.report import Layer, Viewer, log_to_rerun

VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
TIME = np.array([0.0, 2.5])
WARM = Layer(
    "temperature", "K", TIME, np.array([[300.0, 300, 300], [300, 310, 320]]), "temperature"
)
OFF = Layer("residual", "K", TIME, np.array([[0.0, -1, 1], [np.nan, 0.5, 0]]), "residual")
FIELD = Layer("conductivity", "W/m/K", None, np.array([1.0, 1, 1]), "field")
SHOWN = Viewer("plate", VERTICES, np.array([[0, 1, 2]]), (OFF, WARM, FIELD))


class Stream:
    """Keeps what it is sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, float, Any, bool]] = []
        self.now = -1.0

    def set_time(self, timeline: str, *, duration: float) -> None:
        assert timeline == "time"
        self.now = duration

    def log(self, name: str, mesh: Any, *, static: bool) -> None:
        self.sent.append((name, self.now, mesh, static))


def test_each_frame_of_each_layer_is_sent_in_its_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    class Rerun:
        Mesh3D = staticmethod(lambda **parts: parts)

    monkeypatch.setitem(sys.modules, "rerun", Rerun)
    stream = Stream()
    log_to_rerun(stream, SHOWN)
    names = [(name, now, static) for name, now, _, static in stream.sent]
    assert names == [
        ("object/temperature [K]", 0.0, False), ("object/temperature [K]", 2.5, False),
        ("object/residual [K]", 0.0, False), ("object/residual [K]", 2.5, False),
        ("object/conductivity [W/m/K]", 2.5, True),
    ]  # fmt: skip
    warm = stream.sent[1][2]["vertex_colors"].astype(int)
    assert warm[0].sum() < warm[1].sum() < warm[2].sum()
    blue, red = stream.sent[2][2]["vertex_colors"][1:]
    assert blue[2] > blue[0] and red[0] > red[2]
    assert stream.sent[3][2]["vertex_colors"][0].tolist() == [128, 128, 128]


def test_rerun_takes_it() -> None:
    rerun = pytest.importorskip("rerun", reason="the extra thermofield[rerun] is not installed")
    stream = rerun.RecordingStream("thermo_test")
    memory = stream.memory_recording()
    log_to_rerun(stream, SHOWN)
    assert memory.num_msgs() >= 5


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(InputError, match=r"thermofield\[rerun\]"):
        log_to_rerun(Stream(), SHOWN)

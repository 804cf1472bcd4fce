"""The steel rod: a record made by central differences, brought back by the example's own fit."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize
from scripts import load_example

from thermo.inverse import Meshing
from thermo.observe import read_scene

ALPHA, LOSS = 5.0e-6, 8.0  # m2/s, W/m2/K
OFF = np.array([0.2, -0.1, 0.15, -0.2, 0.1, -0.15])  # K, of the inner couples


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("steel_rod", monkeypatch)


def write_record(example: ModuleType, folder: Path) -> None:
    """A rod whose last end warms up by 30 K, as eight couples would read it, in degrees Celsius."""
    points, between = 71, 10
    place = np.linspace(0.0, example.LENGTH, points)
    sink = 2 * LOSS / (example.RADIUS * 4e6)
    time = np.arange(0.0, 6000.1, 20.0)

    def ends(when: float) -> tuple[float, float]:
        return 20.0, 20.0 + 30.0 * (1 - np.exp(-when / 1500.0))

    def rate(when: float, inner: np.ndarray) -> np.ndarray:
        first, last = ends(when)
        full = np.concatenate([[first], inner, [last]])
        bend = (full[2:] - 2 * inner + full[:-2]) / (place[1] - place[0]) ** 2
        return ALPHA * bend - sink * (inner - 20.0)

    found = solve_ivp(
        rate, (0.0, time[-1]), np.full(points - 2, 20.0), method="LSODA", t_eval=time,
        rtol=1e-7, atol=1e-7,
    )  # fmt: skip
    couples = np.column_stack(
        [np.full(len(time), 20.0), *(found.y[between - 1 :: between][:6] + OFF[:, None]),
         [ends(when)[1] for when in time]]
    )  # fmt: skip
    lines = ["Time (sec)\t" + "\t".join(f"TC {n}" for n in range(1, 9))]
    for when, row in zip(time, couples, strict=True):
        lines.append("\t".join(f"{one:.4f}" for one in (when, *row)))
    path = folder / example.RECORD
    path.parent.mkdir(parents=True)
    path.write_text("\n".join(lines), encoding="utf-8")


def test_diffusivity_loss_and_offsets_come_back(
    example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What its cells make wrong is below a per cent here, and measuring it would take two minutes.
    plain_mesh = Meshing(order=1, max_nodes=4000, corrected=False)
    monkeypatch.setattr(example, "Meshing", lambda **given: plain_mesh)
    write_record(example, tmp_path / "data")
    # What this finds is below; its fits are as many again as all others.
    room = example.Surroundings(25.0 + example.KELVIN, 0.1, -0.2)
    monkeypatch.setattr(example, "set_right", lambda *given: room)
    (plain, freed, right), around = example.run(tmp_path / "data", tmp_path / "scene")
    assert around == room
    assert right.diffusivity != pytest.approx(plain.diffusivity, rel=1e-3)
    other = read_scene(tmp_path / "scene_ends_right").runs["heating"]
    assert other.ambient_temperature == room.room
    ends = [one.temperature[0] - example.KELVIN for one in other.prescribed]
    np.testing.assert_allclose(ends, [19.9, 20.2], atol=1e-9)
    assert plain.rmse > 0.1
    assert freed.rmse < 0.03
    assert freed.diffusivity == pytest.approx(ALPHA, rel=0.04)
    assert freed.convection == pytest.approx(LOSS, rel=0.15)
    assert freed.rmse < plain.rmse_free + 0.01
    picture = tmp_path / "rod.png"
    example.draw(picture, plain)
    assert picture.stat().st_size > 10_000


def test_room_and_ends_are_the_most_likely_ones(example: ModuleType) -> None:
    random, frames = np.random.default_rng(0), 400
    slopes, rest = random.normal(size=(6, 3)), random.normal(size=6)
    read = example.Surroundings(291.0)

    def fitted(around: object) -> object:
        moved = np.array([around.room - 291.0, around.first, around.last])  # type: ignore[attr-defined]
        left = np.tile(rest + slopes @ moved, (frames, 1))
        time = np.arange(float(frames))
        return example.Result(4e-6, 4.0, 0.1, 0.1, rest, time, left, np.zeros_like(left))

    found = example.set_right(fitted, read, fitted(read))

    def unlikely(at: np.ndarray) -> float:
        left = rest + slopes @ (at - [291.0, 0.0, 0.0])
        believed = (at - [example.ROOM[0], 0.0, 0.0]) / [example.ROOM[1], example.OFF, example.OFF]
        # All of a couple's readings count as one.
        return float((left**2).sum() / example.RESOLUTION**2 + (believed**2).sum())

    wanted = minimize(unlikely, [291.0, 0.0, 0.0], tol=1e-12).x
    got = [found.room, found.first, found.last]
    np.testing.assert_allclose(got, wanted, rtol=1e-5, atol=1e-5)


def test_a_missing_record_is_told_of(example: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="THERMOFIELD_DATA"):
        example.run(tmp_path, tmp_path / "out")

"""Recordings from arrays and NPZ: masks, missing values, round trips and refusals."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from thermo.errors import InputError
from thermo.observe import Recording, read_recording, write_recording

KELVIN = st.floats(150.0, 5000.0)


@st.composite
def recordings(draw: st.DrawFn) -> dict[str, np.ndarray | None]:
    """Draw the arrays of recordings with missing values and with or without quiet frames."""
    samples, frames = draw(st.integers(1, 4)), draw(st.integers(2, 5))
    points = draw(hnp.arrays(float, (samples, 3), elements=st.floats(-10, 10)))
    steps = draw(hnp.arrays(float, frames, elements=st.floats(1e-3, 1e3)))
    temperature = draw(hnp.arrays(float, (frames, samples), elements=KELVIN))
    valid = draw(hnp.arrays(bool, (frames, samples)))
    valid[[0, -1], 0] = True
    missing = draw(hnp.arrays(bool, (frames, samples)))
    missing[[0, -1], 0] = False
    temperature[missing] = np.nan
    quiet = None
    if draw(st.booleans()):
        quiet = draw(hnp.arrays(float, (3, samples), elements=KELVIN | st.just(np.nan)))
    return {
        "points": points, "time": np.cumsum(steps), "temperature": temperature, "valid": valid,
        "quiet": quiet,
    }  # fmt: skip


def assert_same(one: Recording, other: Recording) -> None:
    for name in ("points", "time", "temperature", "valid"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.quiet is None) == (other.quiet is None)
    if one.quiet is not None and other.quiet is not None:
        np.testing.assert_array_equal(one.quiet, other.quiet)


@settings(max_examples=40, deadline=None)
@given(recordings())
def test_npz_round_trip_changes_no_bit(drawn: dict) -> None:
    recording = Recording(**drawn)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "run.npz"
        write_recording(path, recording)
        assert_same(read_recording(path), recording)
        assert os.listdir(name) == ["run.npz"]


@settings(max_examples=40, deadline=None)
@given(recordings())
def test_placeholders_are_finite_and_do_not_move_the_mean(drawn: dict) -> None:
    recording = Recording(**drawn)
    assert np.isfinite(recording.temperature).all()
    for values, valid in zip(recording.temperature.T, recording.valid.T, strict=True):
        if valid.any():
            np.testing.assert_allclose(values.mean(), values[valid].mean(), rtol=1e-12)


def test_missing_and_masked_values_are_not_valid(recorded: dict[str, np.ndarray]) -> None:
    recorded["temperature"][1, 2] = np.nan
    recorded["temperature"][0, 0] = 0.0  # a dead pixel, and marked as such
    mask = np.ones((4, 3), dtype=np.uint8)
    mask[0, 0] = 0
    recording = Recording(**recorded, valid=mask)
    expected = np.ones((4, 3), dtype=bool)
    expected[0, 0] = expected[1, 2] = False
    np.testing.assert_array_equal(recording.valid, expected)
    assert recording.temperature[0, 0] == pytest.approx(recorded["temperature"][1:, 0].mean())


def test_one_mask_a_sample_holds_for_all_frames(recorded: dict[str, np.ndarray]) -> None:
    recording = Recording(**recorded, valid=np.array([True, False, True]))
    np.testing.assert_array_equal(recording.valid.all(axis=0), [True, False, True])
    assert not recording.valid[:, 1].any()


def test_leaves_are_numpy_float64(recorded: dict[str, np.ndarray]) -> None:
    recorded["temperature"] = recorded["temperature"].astype(np.float32)
    leaves = jax.tree.leaves(Recording(**recorded))
    assert len(leaves) == 5
    assert all(isinstance(leaf, np.ndarray) and leaf.dtype in (float, bool) for leaf in leaves)


def test_npz_with_other_arrays_is_read(folder: Path, recorded: dict[str, np.ndarray]) -> None:
    path = folder / "more.npz"
    np.savez(path, emissivity_map=np.ones(3), allow_pickle=False, **recorded)
    assert_same(read_recording(path), read_recording(folder / "lamp.npz"))


def with_value(name: str, index: object, value: float):
    def change(data: dict) -> None:
        data[name][index] = value

    return change


def replaced(name: str, value):
    def change(data: dict) -> None:
        data[name] = value(data) if callable(value) else np.asarray(value)

    return change


BAD = {
    "points_nan": (
        with_value("points", (1, 2), np.nan), ": points", "sample 1", "finite metres", "drop"),
    "points_infinite": (
        with_value("points", (2, 0), np.inf), ": points", "sample 2", "finite metres", "drop"),
    "points_flat": (
        replaced("points", lambda d: d["points"][:, :2]), ": points", "(3, 2)", "(samples, 3)",
        "x, y, z"),
    "points_none": (
        replaced("points", np.zeros((0, 3))), ": points", "(0, 3)", "at least one", "x, y, z"),
    "points_text": (
        replaced("points", [["a", "b", "c"]] * 3), ": points", "<U1", "numbers", "floating-point"),
    "time_nan": (
        with_value("time", 2, np.nan), ": time", "nan at frame 2", "finite", "drop"),
    "time_infinite": (
        with_value("time", 3, np.inf), ": time", "inf at frame 3", "finite", "drop"),
    "time_back": (
        with_value("time", 2, 0.25), ": time", "0.5 s at frame 1, then 0.25 s", "increasing",
        "sort"),
    "time_repeated": (
        with_value("time", 1, 0.0), ": time", "0 s at frame 0, then 0 s", "increasing", "repeated"),
    "time_negative": (
        with_value("time", 0, -1.0), ": time", "-1 s", "at least 0 s", "quiet"),
    "time_two_dimensional": (
        replaced("time", lambda d: d["time"][:, None]), ": time", "(4, 1)", "(frames,)", "record"),
    "one_frame": (
        lambda d: d.update(time=d["time"][:1], temperature=d["temperature"][:1]),
        ": time", "1 frames", "at least 2", "record"),
    "no_frame": (
        lambda d: d.update(time=d["time"][:0], temperature=d["temperature"][:0]),
        ": time", "0 frames", "at least 2", "record"),
    "celsius": (
        replaced("temperature", lambda d: d["temperature"] - 273.15), ": temperature",
        "12 of 12 values", "150 to 5000 K", "273.15"),
    "counts": (
        replaced("temperature", lambda d: d["temperature"] * 100), ": temperature",
        "12 of 12 values", "150 to 5000 K", "camera counts"),
    "dead_pixel": (
        with_value("temperature", (3, 1), 0.0), ": temperature", "0 (1 of 12 values outside, "
        "the first at frame 3, sample 1)", "150 to 5000 K", "dead pixels as NaN"),
    "temperature_infinite": (
        with_value("temperature", (0, 2), np.inf), ": temperature", "at frame 0, sample 2",
        "NaN where", "valid"),
    "all_missing": (
        replaced("temperature", np.full((4, 3), np.nan)), ": temperature", "0 of 4 frames",
        "two frames", "export"),
    "one_frame_with_values": (
        with_value("temperature", slice(1, None), np.nan), ": temperature", "1 of 4 frames",
        "two frames", "export"),
    "transposed": (
        replaced("temperature", lambda d: d["temperature"].T), ": temperature", "(3, 4)",
        "(4, 3)", "transpose"),
    "frames_do_not_fit": (
        replaced("temperature", lambda d: d["temperature"][:3]), ": temperature", "(3, 3)",
        "(4, 3)", "one row a frame"),
    "complex": (
        replaced("temperature", lambda d: d["temperature"] * 1j), ": temperature", "complex128",
        "numbers", "floating-point"),
    "quiet_shape": (
        replaced("quiet", lambda d: d["quiet"][:, :2]), ": quiet", "(2, 2)", "3 samples", "leave"),
    "quiet_celsius": (
        replaced("quiet", lambda d: d["quiet"] - 273.15), ": quiet", "6 of 6", "kelvin", "273.15"),
    "valid_shape": (
        replaced("valid", np.ones((3, 4), bool)), ": valid", "(3, 4)", "(4, 3)", "store true"),
    "valid_numbers": (
        replaced("valid", np.full((4, 3), 0.5)), ": valid", "float64", "true or false",
        "store true"),
    "points_missing": (
        lambda d: d.pop("points"), "bad.npz", "quiet, temperature, time", "points, time",
        "add `points`"),
    "time_missing": (
        lambda d: d.pop("time"), "bad.npz", "points, quiet", "points, time", "add `time`"),
    "valid_misspelt": (
        replaced("vaild", np.ones((4, 3), bool)), "bad.npz", "vaild", "optional quiet, valid",
        "`valid`"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_recording_is_refused(case, tmp_path, recorded, refuses) -> None:
    change, where, value, limit, remedy = BAD[case]
    change(recorded)
    path = tmp_path / "bad.npz"
    np.savez(path, allow_pickle=False, **recorded)
    error = refuses(
        lambda: read_recording(path), where=where, value=value, limit=limit, remedy=remedy
    )
    assert str(path) in error.where


@pytest.mark.parametrize("name", ["points", "time", "temperature", "quiet", "valid"])
def test_pickled_array_is_never_loaded(name, tmp_path, recorded, refuses) -> None:
    touched = tmp_path / "touched"

    class Trap:
        def __reduce__(self):
            return Path.touch, (touched,)

    recorded[name] = np.array([Trap()], dtype=object)
    np.savez(tmp_path / "bad.npz", **recorded)
    refuses(
        lambda: read_recording(tmp_path / "bad.npz"), where=f"bad.npz: {name}",
        value="object array", limit="plain numbers", remedy="astype",
    )  # fmt: skip
    assert not touched.exists()


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.0, 0.999))
def test_truncated_npz_is_refused(share: float) -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "cut.npz"
        np.savez(path, points=np.zeros((3, 3)), time=np.arange(4.0), temperature=np.ones((4, 3)))
        whole = path.read_bytes()
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match="not a whole NPZ file") as caught:
            read_recording(path)
        assert str(path) in caught.value.where
        assert f"{int(share * len(whole))} bytes" in str(caught.value.value)


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 10_000), byte=st.integers(1, 255))
def test_damaged_npz_is_refused_or_reads_the_same(place: int, byte: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "bad.npz"
        temperature = np.linspace(280.0, 320.0, 12).reshape(4, 3)
        recording = Recording(np.zeros((3, 3)), np.arange(4.0), temperature)
        write_recording(path, recording)
        whole = bytearray(path.read_bytes())
        whole[place % len(whole)] ^= byte
        path.write_bytes(bytes(whole))
        try:
            found = read_recording(path)
        except InputError as error:
            assert str(path) in error.where
        else:  # a byte that means nothing, such as a time stamp of the archive
            assert_same(found, recording)


@pytest.mark.parametrize("content", [b"", b"time,temperature\n", b"\x80\x04K\x01.", b"PK\x05\x06"])
def test_other_content_in_npz_is_refused(content, tmp_path, refuses) -> None:
    (tmp_path / "bad.npz").write_bytes(content)
    refuses(
        lambda: read_recording(tmp_path / "bad.npz"), where="bad.npz",
        value=f"{len(content)} bytes", limit="zip", remedy="truncated",
    )  # fmt: skip


def test_npy_under_the_name_npz_is_refused(tmp_path, refuses) -> None:
    with open(tmp_path / "bad.npz", "wb") as stream:
        np.save(stream, np.zeros(3))
    refuses(
        lambda: read_recording(tmp_path / "bad.npz"), where="bad.npz", value="bytes",
        limit="zip", remedy="another type",
    )  # fmt: skip


@pytest.mark.parametrize("name", ["absent.npz", "absent.csv", "absent.xls", "."])
def test_missing_file_is_refused(name, tmp_path, refuses) -> None:
    value = "a folder" if name == "." else "no such file"
    refuses(
        lambda: read_recording(tmp_path / name), where=str(tmp_path), value=value,
        limit="existing", remedy="check the name",
    )  # fmt: skip


def test_unknown_file_type_is_refused(tmp_path, refuses) -> None:
    (tmp_path / "run.mat").write_bytes(b"MATLAB")
    refuses(
        lambda: read_recording(tmp_path / "run.mat"), where="run.mat", value=".mat",
        limit=".npz, .csv", remedy="NPZ or CSV",
    )  # fmt: skip


def test_unwritable_output_is_refused(tmp_path, recorded, refuses) -> None:
    refuses(
        lambda: write_recording(tmp_path / "no" / "run.npz", Recording(**recorded)),
        where="run.npz", value="FileNotFoundError", limit="written to", remedy="another output",
    )  # fmt: skip


def test_failed_write_leaves_the_old_file(tmp_path, recorded, monkeypatch) -> None:
    path = tmp_path / "run.npz"
    write_recording(path, Recording(**recorded))
    before = path.read_bytes()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_recording(path, Recording(**recorded))
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["run.npz"]

"""Radiometric JPEG of DJI, by a stand-in for the tool of its Thermal SDK."""

from __future__ import annotations

import io
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import Stated, read_frames
from thermo.imaging.readers import DjiReader, FlirReader, _dji_reader

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the stand-in is a script with a #! line")

WIDTH, HEIGHT = 8, 6
PLACES = np.arange(WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH) / 4

# What the tool takes and prints, by `sample/dji_irp.cpp` of the Thermal SDK 1.4. The picture's last
# word is the temperature of its first pixel; a picture without one is no R-JPEG.
STAND_IN = f"""#!{sys.executable}
import argparse, os, struct, sys, time
options = argparse.ArgumentParser()
for short, long in (("-s", "--source"), ("-a", "--action"), ("-o", "--output")):
    options.add_argument(short, long, required=True)
options.add_argument("--measurefmt", default="int16")
asked = options.parse_args()
here = os.path.dirname(os.path.realpath(__file__))
if here not in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep):
    sys.exit("dji_irp: error while loading shared libraries: libdirp.so: cannot open")
open("logger.txt", "w").close()
print("DIRP API version number : 0x13")
print("R-JPEG file path :", asked.source)
content = open(asked.source, "rb").read()
head, mark, word = content.rpartition(b"first=")
if not mark:
    print("ERROR: create R-JPEG dirp handle failed")
    print("Test done with return code -3")
    sys.exit(-3)
if word == b"slow":
    time.sleep(30)
print("R-JPEG resolution size")
print("      image  width :", {WIDTH})
print("      image height :", {HEIGHT})
print("Run action 1")
assert asked.action == "measure"
found = [float(word) + place / 4 for place in range({WIDTH * HEIGHT})]
if asked.measurefmt == "float32":
    data = struct.pack(f"<{{len(found)}}f", *found)
else:
    data = struct.pack(f"<{{len(found)}}h", *(round(10 * one) for one in found))
open(asked.output, "wb").write(data[: len(data) - 4 * os.path.exists(here + "/full")])
print("Save image file as :", asked.output)
print("Test done with return code 0")
"""


def picture(word: str, date: str | None = None, exposed: str | None = None) -> bytes:
    """A JPEG as the stand-in takes it, with the dates that DJI's cameras write."""
    exif = Image.Exif()
    exif[0x010F] = "DJI"
    if date is not None:
        exif.get_ifd(0x8769)[0x9003] = date
    xmp = "" if exposed is None else f'<rdf:Description drone-dji:UTCAtExposure="{exposed}"/>'
    stream = io.BytesIO()
    Image.new("RGB", (2 * WIDTH, 2 * HEIGHT)).save(stream, "JPEG", exif=exif)
    jpeg, packet = stream.getvalue(), b"http://ns.adobe.com/xap/1.0/\0" + xmp.encode()
    segment = b"\xff\xe1" + (len(packet) + 2).to_bytes(2, "big") + packet
    end = 4 + int.from_bytes(jpeg[4:6], "big")
    return jpeg[:end] + segment + jpeg[end:] + word.encode()


@pytest.fixture
def tool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The stand-in, in a folder of its own on the PATH."""
    file = tmp_path / "sdk" / "dji_irp"
    file.parent.mkdir()
    file.write_text(STAND_IN)
    file.chmod(0o755)
    monkeypatch.setenv("PATH", str(file.parent))
    monkeypatch.delenv("THERMOFIELD_DJI_IRP", raising=False)
    return file


def test_temperatures_are_the_tool_s(
    tool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    path = folder / "-o DJI_0001_T.JPG"
    path.write_bytes(picture("first=21.5"))
    frames = read_frames(path, Stated())
    assert DjiReader().recognises(path) and not FlirReader().recognises(path)
    np.testing.assert_allclose(frames.values, [PLACES + 21.5 + 273.15], atol=3e-5)
    assert not frames.counts and frames.time == [0.0]
    assert [one.name for one in folder.iterdir()] == [path.name], "nothing is left behind"


def test_the_variable_goes_before_the_path_and_may_be_a_link(
    tool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "other" / "irp_1_8"
    other.parent.mkdir()
    shutil.copy(tool, other)
    tool.write_text("broken")
    link = tmp_path / "link"
    link.symlink_to(other)
    monkeypatch.setenv("THERMOFIELD_DJI_IRP", str(link))
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=20"))
    assert read_frames(path, Stated()).values[0, 0, 0] == np.float32(293.15)


def test_a_folder_by_the_times_of_exposure(tool: Path, tmp_path: Path) -> None:
    folder = tmp_path / "shots"
    folder.mkdir()
    for number, part in ((1, "900000"), (2, "400125"), (10, "950000")):
        second = 14 + (number > 1)
        (folder / f"DJI_{number}_T.JPG").write_bytes(
            picture(f"first={number}", "2025:08:25 12:14:15", f"2025-08-25T10:14:{second}.{part}")
        )
    frames = read_frames(folder, Stated())
    np.testing.assert_allclose(frames.time, [0.0, 0.500125, 1.05], atol=1e-6)
    np.testing.assert_allclose(frames.values[:, 0, 0], [274.15, 275.15, 283.15], atol=3e-5)
    moved = read_frames(folder, Stated(start=-1.0))
    np.testing.assert_allclose(moved.time, [-1.0, -0.499875, 0.05], atol=1e-6)


@pytest.mark.parametrize(
    ("exposed", "dates", "expected"),
    [
        ((None, None), ("2025:08:25 12:14:15", "2025:08:25 12:14:17"), [0.0, 2.0]),
        (("2025-08-25T10:14:15.5", None), ("2025:08:25 12:14:15", "2025:08:25 12:14:17"), [0, 2]),
        (("no time", "10"), ("2025:08:25 12:14:15", "2025:08:25 12:14:17"), [0.0, 2.0]),
        (("2025-08-25T10:14:15.5Z", "2025-08-25T12:14:16+02:00"), (None, None), [0.0, 0.5]),
        ((None, None), ("2025:08:25 12:14:15", "2025:08:25 12:14:15"), None),
        ((None, None), (None, "2025:08:25 12:14:15"), None),
    ],
)
def test_dates_stand_in_for_times_of_exposure(
    tool: Path, tmp_path: Path, exposed: tuple, dates: tuple, expected: list[float] | None
) -> None:
    folder = tmp_path / "shots"
    folder.mkdir()
    for number in (0, 1):
        content = picture(f"first={number}", dates[number], exposed[number])
        (folder / f"{number}.jpg").write_bytes(content)
    if expected is not None:
        np.testing.assert_allclose(read_frames(folder, Stated()).time, expected, atol=1e-6)
        return
    with pytest.raises(InputError, match="nothing tells the times"):
        read_frames(folder, Stated())
    np.testing.assert_array_equal(read_frames(folder, Stated(rate=2.0)).time, [0.0, 0.5])


def test_a_photograph_in_the_folder_is_named_with_the_tool_s_words(
    tool: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "shots"
    folder.mkdir()
    (folder / "DJI_1_T.JPG").write_bytes(picture("first=20"))
    (folder / "DJI_1_W.JPG").write_bytes(picture(""))
    with pytest.raises(InputError, match="dji_irp cannot read this picture") as caught:
        read_frames(folder, Stated(rate=1.0))
    for part in ("DJI_1_W.JPG", "exit status 253: ERROR: create R-JPEG dirp handle", "_W"):
        assert part in str(caught.value)


def test_what_is_not_as_long_as_the_tool_says_is_refused(tool: Path, tmp_path: Path) -> None:
    (tool.parent / "full").touch()
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=20"))
    with pytest.raises(InputError, match="not of the size that it says") as caught:
        read_frames(path, Stated())
    assert "188 bytes" in str(caught.value) and "192 bytes: 8 x 6 px" in str(caught.value)


@pytest.mark.parametrize(
    ("script", "part"),
    [
        ("#!/bin/sh\nexit 0\n", "does not say the picture's size: nothing printed"),
        ("#!/bin/sh\necho first words >&2\nexit 7\n", "exit status 7: first words"),
        ("#!/nowhere/sh\n", "FileNotFoundError"),
    ],
)
def test_a_tool_that_is_another_one_is_told(
    tool: Path, tmp_path: Path, script: str, part: str
) -> None:
    tool.write_text(script)
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=20"))
    with pytest.raises(InputError, match="cannot read this picture") as caught:
        read_frames(path, Stated())
    assert part in str(caught.value) and "a.jpg" in str(caught.value)


def test_a_tool_that_hangs_is_given_up(
    tool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_dji_reader, "_LONGEST", 0.5)
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=slow"))
    with pytest.raises(InputError, match=r"no answer within 0\.5 s"):
        read_frames(path, Stated())


def test_a_variable_that_names_no_program_is_refused(
    tool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=20"))
    monkeypatch.setenv("THERMOFIELD_DJI_IRP", str(path))
    with pytest.raises(InputError, match="THERMOFIELD_DJI_IRP: no such program"):
        read_frames(path, Stated())


def test_counts_are_not_to_be_had(tool: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    path.write_bytes(picture("first=20"))
    with pytest.raises(InputError, match="different units"):
        read_frames(path, Stated(unit="counts"))

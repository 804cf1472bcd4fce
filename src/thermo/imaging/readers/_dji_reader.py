"""Radiometric JPEG of DJI's cameras, by the tool of DJI's Thermal SDK."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._closed import closed
from ._jpeg import is_of_dji, jpeg_frames
from ._reader import AbstractReader
from ._stated import Stated

_NAME: Final = "dji_irp"
_VARIABLE: Final = "THERMOFIELD_DJI_IRP"

_LONGEST: Final = 60.0
"""What the tool may take for one picture before it is given up [s]."""

_SIZE = re.compile(r"image\s+width\s*:\s*([0-9]+)\s+image\s+height\s*:\s*([0-9]+)")


@final
class DjiReader(AbstractReader):
    """Radiometric JPEG of DJI (R-JPEG): temperatures [K] by the settings in each file.

    DJI keeps the format to itself. Its Thermal SDK brings a tool that reads it, `dji_irp`, which is
    run on each file where it is on the PATH or where the environment variable
    `THERMOFIELD_DJI_IRP` names it. Emissivity, reflected temperature, distance and humidity are
    those that the file holds. Times are those of the exposures where the files hold them, else the
    dates; where those are whole seconds that repeat, state `rate`.

    Source: the DJI Thermal SDK 1.4, `sample/dji_irp.cpp`, for what the tool takes and prints.
    """

    def format(self) -> str:
        """The files that it reads."""
        return f"radiometric JPEG of DJI (one, or a folder of them), by {_NAME}"

    def recognises(self, path: Path) -> bool:
        """By the first bytes: DJI's, and without FLIR's data."""
        return is_of_dji(path)

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] and their times [s]; raises `InputError`."""
        tool = _tool(path)
        return jpeg_frames(
            path, lambda file, content: _celsius(file, content, tool), given, unit="C"
        )  # fmt: skip


def _tool(path: Path) -> Path:
    named = os.environ.get(_VARIABLE)
    found = shutil.which(named or _NAME)
    if found is not None:
        return Path(found).resolve()
    if named:
        raise InputError(
            "no such program", where=_VARIABLE, value=named,
            limit=f"the {_NAME} of DJI's Thermal SDK, which may be run",
            remedy="correct the name; after unpacking on Linux the file needs chmod +x",
        )  # fmt: skip
    raise closed(
        path, "a JPEG of DJI", "DJI Thermal Analysis Tool",
        other=f"install DJI's Thermal SDK and set the environment variable {_VARIABLE} to its "
        f"{_NAME}; or ",
    )  # fmt: skip


def _celsius(path: Path, content: bytes, tool: Path) -> Float[np.ndarray, "rows columns"]:
    with tempfile.TemporaryDirectory() as folder:
        # Its own name for the picture, so that no other one can be mistaken for an option.
        picture, raw = Path(folder, "in.jpg"), Path(folder, "out.raw")
        picture.write_bytes(content)
        words = ["-s", picture, "-a", "measure", "-o", raw, "--measurefmt", "float32"]
        said = _run(path, [tool, *words], folder)
        values = raw.read_bytes() if raw.is_file() else b""
    size = _SIZE.search(said)
    if size is None:
        raise _failed(path, f"it does not say the picture's size: {_first_words(said)}")
    columns, rows = (int(one) for one in size.groups())
    if len(values) != 4 * rows * columns:
        raise InputError(
            f"what {_NAME} wrote is not of the size that it says", where=str(path),
            value=f"{len(values)} bytes",
            limit=f"{4 * rows * columns} bytes: {columns} x {rows} px of four each",
            remedy="look for room on the disk, and for another version of DJI's Thermal SDK",
        )  # fmt: skip
    return np.frombuffer(values, "<f4").reshape(rows, columns)


def _run(path: Path, command: list[str | Path], folder: str) -> str:
    """What the tool prints."""
    # Its libraries lie beside it, where Linux does not look by itself.
    places = [str(Path(command[0]).parent), os.environ.get("LD_LIBRARY_PATH", "")]
    try:
        done = subprocess.run(
            command, cwd=folder, timeout=_LONGEST, stdin=subprocess.DEVNULL, capture_output=True,
            text=True, errors="replace", check=False,
            env=os.environ | {"LD_LIBRARY_PATH": os.pathsep.join(filter(None, places))},
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise _failed(path, f"no answer within {_LONGEST:g} s") from error
    except OSError as error:
        raise _failed(path, f"{type(error).__name__}: {error.strerror}") from error
    if done.returncode != 0:
        words = _first_words(f"{done.stderr}\n{done.stdout}")
        raise _failed(path, f"exit status {done.returncode}: {words}")
    return done.stdout


def _failed(path: Path, value: str) -> InputError:
    return InputError(
        f"{_NAME} cannot read this picture", where=str(path), value=value,
        limit="a radiometric JPEG as DJI's thermal camera stored it",
        remedy="copy it from the camera unchanged; take photographs (names that end in _V, _W or "
        "_Z) out of the folder; a newer camera needs a newer Thermal SDK",
    )  # fmt: skip


def _first_words(said: str) -> str:
    """The first line that tells of an error, else the first one, of what the tool printed."""
    lines = [" ".join(line.split()) for line in said.splitlines() if line.strip()]
    told = [line for line in lines if "error" in line.casefold()]
    return (told or lines or ["nothing printed"])[0][:160]

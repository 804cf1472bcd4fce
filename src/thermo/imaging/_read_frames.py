"""Frames from whatever a camera or its program wrote."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Final

from thermo.errors import InputError

from ._frames import Frames
from .readers import (
    AbstractReader,
    CsvFolderReader,
    DjiReader,
    FlirReader,
    FlukeReader,
    HccReader,
    Hdf5Reader,
    NpyReader,
    NpzReader,
    Stated,
    TiffReader,
    check_open,
)

GROUP: Final = "thermo.frames"
"""Entry points that name a reader of frames."""


def read_frames(path: Path, given: Stated | None = None) -> Frames:
    """Read what a camera recorded: a file, or a folder of single frames.

    The first reader that recognises `path` reads it: this package's own (NPZ, NPY, TIFF, HDF5,
    radiometric JPEG of FLIR and of DJI, Fluke IS2, Telops HCC, folders of CSV), then those of
    installed packages, which register theirs as entry points of the group `thermo.frames` and are
    loaded only then.

    Arguments: `given`, what the user states where the file says nothing: rate [Hz] or times [s],
    unit, scale [K] and offset [K].

    Returns temperatures [K] or the sensor's signal [1], with times [s].

    Raises `InputError` if nothing is there or recognises it, if it is of a closed format, and for
    damaged files and frames that do not belong together.
    """
    stated = Stated() if given is None else given
    _check_there(path)
    check_open(path)
    own = [one for one in _own() if one.recognises(path)]
    if path.is_dir() and len(own) > 1:
        raise InputError(
            "a folder of two formats", where=str(path),
            value="; ".join(one.format() for one in own), limit="frames of one format",
            remedy="put the frames into a folder of their own, without photographs or tables",
        )  # fmt: skip
    for reader in own or _installed(path):
        return reader.read(path, stated)
    known = "; ".join(one.format() for one in _own())
    raise InputError(
        "no reader knows this format", where=str(path), value=_shown(path), limit=known,
        remedy="export the frames in one of these formats, or install a package that registers "
        f"a reader as an entry point of the group {GROUP}",
    )  # fmt: skip


def _own() -> tuple[AbstractReader, ...]:
    return (
        NpzReader(),
        NpyReader(),
        TiffReader(),
        Hdf5Reader(),
        FlirReader(),
        DjiReader(),
        FlukeReader(),
        HccReader(),
        CsvFolderReader(),
    )


def _installed(path: Path) -> Iterator[AbstractReader]:
    for point in sorted(entry_points(group=GROUP), key=lambda one: one.name):
        try:
            reader = point.load()()
            if not isinstance(reader, AbstractReader):
                raise TypeError(f"it makes a {type(reader).__name__}")
            recognised = reader.recognises(path)
        except Exception as fault:
            raise InputError(
                "an installed package's reader cannot be used",
                where=f"entry point {GROUP}: {point.name} = {point.value}",
                value=f"{type(fault).__name__}: {fault}",
                limit="something that makes a thermo.imaging.AbstractReader without arguments",
                remedy="mend that package, or uninstall it",
            ) from fault
        if recognised:
            yield reader


def _check_there(path: Path) -> None:
    there = path.exists()
    if there and not (path.is_dir() and not any(path.iterdir())):
        return
    raise InputError(
        "an empty folder" if there else "nothing there", where=str(path),
        value="no files" if there else "no such file or folder",
        limit="a file of frames, or a folder of single ones",
        remedy="check the name and the folder",
    )  # fmt: skip


def _shown(path: Path) -> str:
    if not path.is_dir():
        return f"a file that ends in {path.suffix or '(nothing)'}"
    suffixes = sorted({one.suffix or one.name for one in path.iterdir()})
    return f"a folder of {', '.join(suffixes[:6])}"

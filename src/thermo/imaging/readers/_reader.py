"""What every reader of a camera's files can do."""

from __future__ import annotations

import abc
from pathlib import Path

import equinox as eqx

from thermo.imaging._frames import Frames

from ._stated import Stated


class AbstractReader(eqx.Module):
    """Reads one format of frames.

    Packages that are installed beside this one register more: an entry point of the group
    `thermo.frames` names something that, called without arguments, returns a reader.
    """

    @abc.abstractmethod
    def format(self) -> str:
        """The files that it reads, in a few words for messages."""

    @abc.abstractmethod
    def recognises(self, path: Path) -> bool:
        """Whether `path`, a file or a folder that is there, looks like this format.

        Names and first bytes are looked at, no more. A damaged file is recognised: `read` tells
        what is wrong with it.
        """

    @abc.abstractmethod
    def read(self, path: Path, given: Stated) -> Frames:
        """The frames: temperatures [K] or the sensor's signal [1], and their times [s].

        `given` is what the user states where the file says nothing. Raises `InputError`, naming
        the file, where it cannot be read whole.
        """

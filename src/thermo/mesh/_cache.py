"""Meshes kept on disk under a hash of what they were made from."""

from __future__ import annotations

import hashlib
import os
import tempfile
import threading
import zipfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float, Int

from thermo._cache_folder import cache_folder

from ._sizing import Sizing
from ._surface import Surface

FORMAT: Final = "thermofield-mesh/2"
"""Version of this file format and of the code that asks the mesher."""

# NumPy reads a header by Python's own parser, which can fail in two threads at once ("AST
# constructor recursion depth mismatch", issue 106905 of CPython).
READING: Final = threading.Lock()


def default_cache() -> Path:
    """`meshes` in the user's cache."""
    return cache_folder() / "meshes"


def content_key(surface: Surface, sizing: Sizing, settings: tuple[float, ...]) -> str:
    """Hash of the surface, the sizing, the mesher's settings and version, and the format."""
    try:
        mesher = version("pytetwild")
    except PackageNotFoundError:
        mesher = "none"
    lengths = (sizing.skin, sizing.core, sizing.depth, sizing.envelope(surface), *settings)
    digest = hashlib.sha256(f"{FORMAT} pytetwild {mesher}".encode())
    digest.update(np.array(lengths, "<f8").tobytes())
    for one in sizing.fine:
        digest.update(np.array(one.edge, "<f8").tobytes())
        digest.update(one.points.astype("<f8").tobytes())
    digest.update(np.array([len(surface.vertices), len(surface.triangles)], "<i8").tobytes())
    digest.update(np.ascontiguousarray(surface.vertices, "<f8").tobytes())
    digest.update(np.ascontiguousarray(surface.triangles, "<i8").tobytes())
    return digest.hexdigest()[:40]


def load_cells(
    entry: Path,
) -> tuple[Float[np.ndarray, "nodes 3"], Int[np.ndarray, "cells 4"]] | None:
    """Nodes and cells of an entry, or None where there is none; a damaged one is removed."""
    try:
        # An open stream is closed also where the archive is cut short.
        with (
            READING,
            entry.open("rb") as stream,
            np.load(stream, allow_pickle=False) as kept,
        ):
            if str(kept["format"]) != FORMAT:
                raise ValueError("another format")
            return kept["nodes"], kept["cells"]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        try:
            entry.unlink(missing_ok=True)
        except OSError:
            # A read-only cache keeps its damage; the mesh is then made each time.
            pass
        return None


def save_cells(entry: Path, nodes: np.ndarray, cells: np.ndarray) -> None:
    """Write an entry in one step, unless there is one; do without where nothing can be written.

    The mesher does not repeat itself. Where two processes mesh one body, the first mesh stays.
    """
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=entry.parent, suffix=".part")
    except OSError:
        return
    try:
        with os.fdopen(handle, "wb") as stream:
            np.savez_compressed(stream, format=np.array(FORMAT), nodes=nodes, cells=cells)
        try:
            os.link(name, entry)
        except FileExistsError:
            pass
        except OSError:
            # Not every file system knows links.
            os.replace(name, entry)
    except OSError:
        pass
    finally:
        Path(name).unlink(missing_ok=True)

"""The finer mesh of a fit, made while the fit goes on."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from thermo.inverse._defect import FINER
from thermo.inverse._stages import corrected
from thermo.inverse._task import Ready, Task, mesh_for


@contextmanager
def finer_mesh_ahead(task: Task, ready: Ready) -> Generator[None]:
    """Make the mesh [m] that corrects a fit beside it; whoever asks for it meanwhile waits.

    Meshing is a process of its own that keeps one core busy, and the first stages of a fit, which
    are compiled at that time, little more than another. Where it fails it fails again in its turn.
    """
    with ThreadPoolExecutor(1) as pool:
        if corrected(task):
            pool.submit(mesh_for, task, ready.stated, FINER)
        yield

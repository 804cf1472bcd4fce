"""The finer mesh of a fit, made while the fit goes on."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from thermo.inverse._defect import finer_mesh
from thermo.inverse._stages import corrected
from thermo.inverse._task import Ready, Task
from thermo.mesh import Mesh


@contextmanager
def finer_mesh_ahead(task: Task, ready: Ready) -> Generator[Callable[[], Mesh] | None]:
    """What waits for the mesh [m] that corrects a fit, which is made beside it; None without one.

    Meshing is a process of its own that keeps one core busy, and the first stages of a fit, which
    are compiled at that time, little more than another. Where it fails, whoever asks for it is
    told, by `InputError`.
    """
    with ThreadPoolExecutor(1) as pool:
        yield pool.submit(finer_mesh, task, ready).result if corrected(task) else None

"""Memory and seconds of this process. NumPy is all it needs: any Python of a peer can import it."""

from __future__ import annotations

import resource
import time
from typing import Any

import numpy as np

SHORT = 10.0
"""Runs below this many seconds are timed three times, and the least counts."""


def peak_gb() -> float:
    """Largest resident memory of this process so far [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def clock(function: Any, *arguments: Any) -> tuple[Any, float, float]:
    """Result, processor seconds and wall seconds, the least of up to three calls."""
    cpu = wall = np.inf
    for count in range(3):
        begun, used = time.perf_counter(), time.process_time()
        result = function(*arguments)
        cpu = min(cpu, time.process_time() - used)
        wall = min(wall, time.perf_counter() - begun)
        if wall > SHORT and count == 0:
            break
    return result, cpu, wall

"""Settings of the whole suite: 64-bit floats, run-time checks of array shapes, no display."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from typing import Any

import hypothesis
import jax
import jaxtyping
import matplotlib
import pytest


def keep_to_one_core() -> None:
    """Give a worker beside others a core of its own, where the system can.

    Kernels are cut in a part a core and wait for the last part, which a neighbour holds up.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[int(worker.removeprefix("gw")) % len(cores)]})


# Programs of tests run once and on little, and most of the suite is compiling: LLVM optimises
# nothing, and kernels are written the shorter way, as `thermo._compiled` asks for. Read when the
# first program is compiled, and by processes that tests start; what the user asks for stays. An XLA
# that does not know one of them ends with its name.
QUICK = "--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false"

keep_to_one_core()
os.environ["XLA_FLAGS"] = f"{QUICK} {os.environ.get('XLA_FLAGS', '')}".strip()
jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")

# Every annotated function and data class of the package is checked as it is called. This must
# come before the first import of the package.
jaxtyping.install_import_hook("thermo", "runtime_types.check")


def optimise_long_runs() -> None:
    """Simulations on finer meshes run for longer than they compile: LLVM optimises those.

    Two searches of a brick whose programs are compiled took 61 s of a core, and take 23 s.
    """
    # Not before the hook above: this imports the package.
    from thermo import _compiled
    from thermo.inverse import _side_by_side as runs

    def options() -> dict[str, Any]:
        return {**_compiled._options(), "xla_backend_optimization_level": 2}

    runs._solve = _compiled.program(runs._solve.__wrapped__, options)


optimise_long_runs()

# Tracing makes millions of short-lived objects beside hundreds of thousands of programs' own, which
# Python's collector looks through again and again: by default a tenth of a worker's time
# (by hand).
gc.set_threshold(20_000, 20, 20)

# How fast examples are made says how busy a machine is.
hypothesis.settings.register_profile(
    "thermo", max_examples=30, deadline=None, derandomize=True, print_blob=True, database=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)  # fmt: skip
hypothesis.settings.load_profile("thermo")


def pytest_collection_finish() -> None:
    """What is there before the first test stays, and is not looked through any more."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="module")
def bricks() -> Iterator[None]:
    """All that a file's tests simulate of the block is on bricks, and shares compiled programs."""
    # Not before the hook above: this imports the package.
    from bricks import lay_bricks

    with pytest.MonkeyPatch.context() as patch:
        lay_bricks(patch)
        yield

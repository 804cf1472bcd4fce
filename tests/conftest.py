"""Settings of the whole suite: 64-bit floats, run-time checks of array shapes, no display."""

from __future__ import annotations

import os

import hypothesis
import jax
import jaxtyping
import matplotlib


def keep_to_one_core() -> None:
    """Give a worker beside others a core of its own, where the system can.

    Kernels are cut in a part a core and wait for the last part, which a neighbour holds up.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[int(worker.removeprefix("gw")) % len(cores)]})


keep_to_one_core()
jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")

# Every annotated function and data class of the package is checked as it is called. This must
# come before the first import of the package.
jaxtyping.install_import_hook("thermo", "runtime_types.check")

# How fast examples are made says how busy a machine is.
hypothesis.settings.register_profile(
    "thermo", max_examples=30, deadline=None, derandomize=True, print_blob=True, database=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)  # fmt: skip
hypothesis.settings.load_profile("thermo")

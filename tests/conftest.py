"""Settings of the whole suite: 64-bit floats, run-time checks of array shapes, no display."""

from __future__ import annotations

import hypothesis
import jax
import jaxtyping
import matplotlib

jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")

# Every annotated function and data class of the package is checked as it is called. This must
# come before the first import of the package.
jaxtyping.install_import_hook("thermo", "runtime_types.check")

hypothesis.settings.register_profile(
    "thermo", max_examples=30, deadline=None, derandomize=True, print_blob=True, database=None
)
hypothesis.settings.load_profile("thermo")

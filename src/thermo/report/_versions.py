"""Versions of what computed a result."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

_DISTRIBUTIONS = (
    "thermofield",
    "jax",
    "jaxlib",
    "equinox",
    "lineax",
    "optimistix",
    "optax",
    "numpy",
    "scipy",
    "trimesh",
    "pytetwild",
    "meshio",
    "plotly",
    "hydra-core",
)


def versions() -> dict[str, str]:
    """The version of Python and of each distribution that can change a number in a result.

    A distribution that is not installed, as `thermofield` run from its sources, says so.
    """
    found = {"python": platform.python_version()}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found

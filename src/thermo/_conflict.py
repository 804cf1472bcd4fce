"""Detects the other package that also imports as `thermo`."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution


def conflict() -> str | None:
    """What to tell the user if the distribution `thermo` is installed beside `thermofield`.

    The distribution `thermo` (chemical thermodynamics, by Caleb Bell) installs a package of the
    same import name. Its files and ours then share one folder, or one hides the other.
    Returns `None` where it is not installed.
    """
    try:
        other = distribution("thermo")
    except PackageNotFoundError:
        return None
    return (
        f"two installed distributions provide the package 'thermo': 'thermofield' and 'thermo' "
        f"{other.version} (chemical thermodynamics), so that either can hide the other.\n"
        f"  found:  {other.locate_file('')}\n"
        f"  remedy: use a virtual environment for each, or run\n"
        f"          pip uninstall thermo thermofield && pip install thermofield"
    )


def refuse_conflict() -> None:
    """Raises `ImportError` with the remedy if the distribution `thermo` is installed too."""
    message = conflict()
    if message is not None:
        raise ImportError(message)

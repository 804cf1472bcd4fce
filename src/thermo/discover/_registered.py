"""Candidates of this package and of those that are installed beside it."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Final

from thermo.discover._candidate import Candidate
from thermo.discover._library import Setting, library
from thermo.errors import InputError

GROUP: Final = "thermo.candidates"
"""Entry points that name a function from a `Setting` to candidates."""


def registered(setting: Setting) -> tuple[Candidate, ...]:
    """The library, and the candidates of installed packages that register some.

    Raises `InputError` where an entry point of the group `thermo.candidates` fails.
    """
    found = list(library(setting))
    for point in sorted(entry_points(group=GROUP), key=lambda one: one.name):
        try:
            found += point.load()(setting)
        except Exception as fault:
            raise InputError(
                "an installed package's candidates cannot be made",
                where=f"entry point {GROUP}: {point.name} = {point.value}",
                value=f"{type(fault).__name__}: {fault}",
                limit="a function from a thermo.discover.Setting to a tuple of candidates",
                remedy="mend that package, or uninstall it",
            ) from fault
    return tuple(found)

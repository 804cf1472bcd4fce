"""Candidates of this package and of those that are installed beside it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib.metadata import entry_points
from typing import Final

from thermo.discover._candidate import Candidate
from thermo.discover._library import Setting, library
from thermo.errors import InputError, meant

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


def only(names: Collection[str]) -> Callable[[Setting], tuple[Candidate, ...]]:
    """Those of the `registered` candidates that have one of these names, for `discover`.

    What is not looked for is not excluded either: an effect that is left out may be named as one
    that reads like it.

    Raises `InputError`, where candidates are made, for a name that none of them has.
    """

    def chosen(setting: Setting) -> tuple[Candidate, ...]:
        every = registered(setting)
        known = [one.card.name for one in every]
        strange = sorted(set(names) - set(known))
        if strange or not names:
            raise InputError(
                "there is no such candidate" if strange else "there is no candidate to look for",
                where="candidates",
                value=", ".join(strange) or "none",
                limit=", ".join(known),
                remedy=f"{meant(strange[0], known) if strange else ''}give some of these, or null "
                "for all",
            )
        return tuple(one for one in every if one.card.name in names)

    return chosen

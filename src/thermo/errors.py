"""The one error that bad input raises: it names the file, the value, the limit and the remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """Input that cannot be used as it stands.

    Arguments:

    - `what`: what is wrong, in a few words.
    - `where`: the file, key or argument that holds it.
    - `value`: what was found there.
    - `limit`: what would have been accepted.
    - `remedy`: what the user can do about it.
    """

    def __init__(self, what: str, *, where: str, value: object, limit: str, remedy: str) -> None:
        self.what, self.where, self.value = what, where, value
        self.limit, self.remedy = limit, remedy
        super().__init__(
            f"{_one_line(where)}: {what}\n  found:  {value}\n  limit:  {limit}\n  remedy: {remedy}"
        )


def _one_line(where: str) -> str:
    """A file's name may hold line ends, which are shown as they are written in Python."""
    return "".join(one if one.isprintable() else repr(one)[1:-1] for one in where)


def meant(name: str, known: Iterable[str]) -> str:
    """The name nearest to one that there is not, as a question before a remedy; or nothing."""
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean {near[0]}? " if near else ""

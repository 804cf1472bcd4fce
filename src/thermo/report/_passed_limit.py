"""The limit that a strength passes which a straight line from zero foretells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def passed_limit(one: Mapping[str, Any]) -> str:
    """What a candidate's strength is above or below, in words; nothing where it can be.

    `one` of the record's candidates has `strength`, and `least` and `most`, what there can be, all
    in its unit, each None where it is not known or there is no limit.
    """
    strength, least, most = one["strength"], one["least"], one["most"]
    if strength is not None and most is not None and strength > most:
        return f"above {most:g}"
    if strength is not None and least is not None and strength < least:
        return f"below {least:g}"
    return ""

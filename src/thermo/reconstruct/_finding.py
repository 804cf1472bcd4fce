"""What a check says of photographs before they are trained on."""

from __future__ import annotations

from typing import NamedTuple


class Finding(NamedTuple):
    """Something that would spoil a training.

    - `what`: was found, in words. `where`: the photograph or the setting.
    - `remedy`: what to do about it.
    - `fatal`: whether no training can come to anything.
    """

    what: str
    where: str
    remedy: str
    fatal: bool

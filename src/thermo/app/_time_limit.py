"""Simulations that are made until their time is spent."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar, final

Found = TypeVar("Found")
Asked = TypeVar("Asked")


class OutOfTime(Exception):
    """The time is spent, or what is left of it is too short."""


@final
@dataclass
class TimeLimit:
    """`budget` [s] from when it is made on; `made`: simulations since then [1]."""

    budget: float
    begun: float = field(default_factory=lambda: time.monotonic())
    made: int = 0

    def spent(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self.begun

    def watched(self, simulated: Callable[[Asked], Found]) -> Callable[[Asked], Found]:
        """The same function, which raises `OutOfTime` where it is called too late."""

        def one(asked: Asked) -> Found:
            if self.spent() > self.budget:
                raise OutOfTime
            found = simulated(asked)
            self.made += 1
            return found

        return one

    def require(self, simulations: int) -> None:
        """Raises `OutOfTime` where the time left [s] is too short for so many more [1]."""
        spent = self.spent()
        if spent + simulations * spent / max(self.made, 1) > self.budget:
            raise OutOfTime

    def words(self) -> str:
        """What it was spent on, and what would help."""
        return (
            f"{self.budget:g} s did not suffice (simulations made: {self.made}, "
            f"{self.spent() / max(self.made, 1):.2g} s each); raise budget"
        )

"""What a search is doing, and how long at the least what is known to be ahead will take."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final, final

import numpy as np

from thermo._duration import duration
from thermo._say import Say

REFIT: Final = "refit"
MEASURE: Final = "measure"


@final
class Pace:
    """Tells each step of a search in words, with the time left where that can be said.

    Arguments:

    - `say`: takes the words.
    - `spared`: grows by what each piece had taken that was found again, not made [s]: a step that
      goes on after an interruption counts as what it took in all.
    - `clock`: gives seconds [s]; only differences count.

    How many rounds a search has is not known, nor what a step takes of whose kind there was none,
    nor whether cells will have to be smaller: nothing is said of either, so that it may take more.
    """

    def __init__(
        self,
        say: Say,
        spared: Sequence[float] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._say, self._spared, self._clock = say, spared, clock
        self._took: dict[str, list[float]] = {}
        self._kind, self._begun, self._known = "", clock(), 0

    def step(self, words: str, kind: str = "", ahead: Mapping[str, int] | None = None) -> None:
        """Tell that a step begins.

        Arguments: `kind`: those of one kind take about as long; `ahead`: how many of each kind are
        to come in this round for all that is known, this one among them [1].
        """
        self._end()
        self._kind = kind
        left = self.left(ahead or {})
        more = "" if left is None else f"; {duration(left)} or more left in this round"
        self._say(words + more)

    def left(self, ahead: Mapping[str, int]) -> float | None:
        """What so many steps of each kind take by the median of those made [s], where all known."""
        if not ahead or not all(self._took.get(kind) for kind in ahead):
            return None
        return float(sum(count * np.median(self._took[kind]) for kind, count in ahead.items()))

    def _end(self) -> None:
        now = self._clock()
        again = float(sum(self._spared[self._known :]))
        if self._kind:
            self._took.setdefault(self._kind, []).append(now - self._begun + again)
        self._begun, self._known = now, len(self._spared)


def silent() -> Pace:
    """One that tells nobody."""
    return Pace(lambda words: None)

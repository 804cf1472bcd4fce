"""Progress of a long run, with the time that is left."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol, final, runtime_checkable

from thermo._duration import duration
from thermo._say import Say


@runtime_checkable
class Stream(Protocol):
    """Where progress is written: `sys.stderr` or anything else with these three methods."""

    def write(self, text: str, /) -> object:
        """Takes text."""
        ...

    def flush(self) -> object:
        """Shows what was written."""
        ...

    def isatty(self) -> bool:
        """Whether a person watches."""
        ...


def say_to(stream: Stream) -> Say:
    """What writes each thing that is being done to a stream, a line each and at once."""

    def say(words: str) -> None:
        stream.write(f"{words}\n")
        stream.flush()

    return say


@final
class Progress:
    """Reports step, loss, seconds elapsed and time left to a stream.

    Arguments:
    - `label`: what runs, in a word or two.
    - `total`: the number of steps, or `None` where it is not known (then no time left is shown).
    - `stream`: usually `sys.stderr`.
    - `clock`: gives seconds [s]; only differences count.
    - `measure`: what the number beside a step is, with its unit.

    On a terminal one line is rewritten, at most four times a second. Elsewhere each report is a
    line of its own, at most one in five seconds. The last state is always shown. The time left is
    told from the second step on, by those since the first one, which meshes and compiles as well.
    Use it in a `with` statement, so that the line is ended after an error too.
    """

    def __init__(
        self,
        label: str,
        total: int | None,
        stream: Stream,
        clock: Callable[[], float] = time.monotonic,
        measure: str = "loss",
    ) -> None:
        self._measure = measure
        self._label, self._total, self._stream, self._clock = label, total, stream, clock
        self._sure = total is not None
        self._terminal = stream.isatty()
        self._interval = 0.25 if self._terminal else 5.0
        self._start = clock()
        self._first: tuple[int, float] | None = None
        # A terminal shows the first step at once; a log file waits for its first interval.
        self._shown = self._start - (self._interval if self._terminal else 0.0)
        self._pending: str | None = None
        self._open_line = False

    def _text(self, step: int, loss: float | None, now: float) -> str:
        elapsed = now - self._start
        about = "" if self._sure else "about "
        of = f" of {about}{self._total}" if self._total else ""
        parts = [f"{self._label}: step {step}{of}"]
        if loss is not None:
            parts.append(f"{self._measure} {loss:.6g}")
        parts.append(f"{duration(elapsed)} elapsed")
        first, then = self._first or (step, now)
        if self._total and first < step < self._total:
            left = (now - then) / (step - first) * (self._total - step)
            parts.append(f"about {duration(left)} left")
        return ", ".join(parts)

    def _show(self, text: str, now: float) -> None:
        if self._terminal:
            self._stream.write(f"\r{text}\x1b[K")
            self._open_line = True
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()
        self._shown, self._pending = now, None

    def update(self, step: int, loss: float | None = None, total: int | None = None) -> None:
        """Tells that `step` steps are done, with the loss [1]; `total`: about how many in all."""
        now = self._clock()
        self._total = self._total if total is None else total
        text = self._text(step, loss, now)
        self._first = self._first or (step, now)
        if now - self._shown >= self._interval:
            self._show(text, now)
        else:
            self._pending = text

    def close(self) -> None:
        """Shows the last state if it was held back, and ends the line. May be called again."""
        if self._pending is not None:
            self._show(self._pending, self._clock())
        if self._open_line:
            self._stream.write("\n")
            self._stream.flush()
            self._open_line = False

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

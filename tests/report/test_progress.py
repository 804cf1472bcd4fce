from __future__ import annotations

import io

import pytest

from thermo.report import Progress, say_to


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def drive(stream: io.StringIO, steps: int, seconds: float) -> str:
    clock = Clock()
    with Progress("fit", steps, stream, clock) as progress:
        for step in range(1, steps + 1):
            clock.now += seconds
            progress.update(step, 10.0 / step)
    return stream.getvalue()


def test_what_is_said_is_seen_at_once_and_stands_on_a_line_of_its_own() -> None:
    kept = io.BytesIO()
    stream = io.TextIOWrapper(kept, "utf-8", write_through=False)
    say = say_to(stream)
    say("meshing")
    assert kept.getvalue() == b"meshing\n"
    say("compiling")
    assert kept.getvalue() == b"meshing\ncompiling\n"


def test_a_log_gets_a_line_every_five_seconds_and_the_last() -> None:
    lines = drive(io.StringIO(), 100, 0.13).splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "fit: step 39 of 100",
        "fit: step 78 of 100",
        "fit: step 100 of 100",
    ]
    assert lines[0] == "fit: step 39 of 100, loss 0.25641, 5 s elapsed, about 8 s left"
    assert lines[-1] == "fit: step 100 of 100, loss 0.1, 13 s elapsed"


def test_the_first_step_does_not_tell_how_long_others_take() -> None:
    stream, clock = io.StringIO(), Clock()
    with Progress("fit", 12, stream, clock) as progress:
        for seconds, step in ((100.0, 1), (6.0, 2), (12.0, 4)):
            clock.now += seconds
            progress.update(step)
    assert stream.getvalue().splitlines() == [
        "fit: step 1 of 12, 1 min 40 s elapsed",
        "fit: step 2 of 12, 1 min 46 s elapsed, about 1 min 00 s left",
        "fit: step 4 of 12, 1 min 58 s elapsed, about 48 s left",
    ]


def test_a_number_of_steps_that_is_not_sure_is_told_as_such() -> None:
    stream, clock = io.StringIO(), Clock()
    with Progress("fit", None, stream, clock) as progress:
        for step, total in ((1, None), (2, 8), (3, 9)):
            clock.now += 6.0
            progress.update(step, total=total)
    assert stream.getvalue().splitlines() == [
        "fit: step 1, 6 s elapsed",
        "fit: step 2 of about 8, 12 s elapsed, about 36 s left",
        "fit: step 3 of about 9, 18 s elapsed, about 36 s left",
    ]


def test_a_terminal_gets_one_line_four_times_a_second() -> None:
    text = drive(Terminal(), 100, 0.01)
    assert 3 <= text.count("\r") <= 6
    assert text.count("\n") == 1 and text.endswith("\x1b[K\n")
    assert "step 100 of 100" in text.split("\r")[-1]


def test_slow_steps_are_all_shown_once() -> None:
    assert drive(io.StringIO(), 4, 6.0).count("\n") == 4


def test_an_error_ends_the_line_and_shows_the_last_state() -> None:
    stream, clock = Terminal(), Clock()
    with pytest.raises(KeyboardInterrupt), Progress("fit", None, stream, clock) as progress:
        progress.update(1)
        clock.now += 0.01
        progress.update(2, 0.5)
        raise KeyboardInterrupt
    assert stream.getvalue().endswith("fit: step 2, loss 0.5, 0 s elapsed\x1b[K\n")
    progress.close()
    assert stream.getvalue().count("\n") == 1


def test_nothing_is_shown_without_a_step() -> None:
    stream = io.StringIO()
    with Progress("fit", 3, stream):
        pass
    assert stream.getvalue() == ""

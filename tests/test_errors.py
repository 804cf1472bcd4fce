"""What a message of bad input looks like."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError


@given(st.text())
def test_a_message_has_four_lines_whatever_the_file_is_called(name: str) -> None:
    error = InputError("no file", where=name, value=3, limit="4", remedy="look")
    assert len(str(error).splitlines()) == 4
    assert error.where == name


def test_a_plain_name_is_shown_as_it_is() -> None:
    error = InputError("no file", where="Größe/scene.json: a", value=3, limit="4", remedy="look")
    assert str(error).startswith("Größe/scene.json: a: no file\n  found:  3\n")

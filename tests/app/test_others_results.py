"""What another verb left in an output folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from thermo.app._others_results import keep_others_results
from thermo.errors import InputError


def left(out: Path, verb: str) -> Path:
    """A folder in which a verb left its record."""
    name = "verdict.json" if verb == "discover" else "result.json"
    (out / name).write_text(json.dumps({"verb": verb}))
    return out


@pytest.mark.parametrize(
    ("verb", "before"),
    [("predict", "invert"), ("discover", "invert"), ("invert", "discover"), ("invert", "predict")],
)
def test_what_another_verb_left_is_not_overwritten(tmp_path: Path, verb: str, before: str) -> None:
    with pytest.raises(InputError, match=f"`thermo {before}` left") as caught:
        keep_others_results(verb, left(tmp_path, before))
    assert str(tmp_path) in str(caught.value) and "out=FOLDER" in str(caught.value)


@pytest.mark.parametrize(
    ("verb", "before"),
    [
        ("invert", "invert"), ("discover", "discover"), ("identify", "invert"),
        ("predict", "discover"), ("render", "invert"), ("ensemble", "invert"),
    ],
)  # fmt: skip
def test_what_shares_no_name_may_stand_beside(tmp_path: Path, verb: str, before: str) -> None:
    keep_others_results(verb, left(tmp_path, before))


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"verb": 3}'])
def test_a_damaged_record_stands_in_nobodys_way(tmp_path: Path, text: str) -> None:
    (tmp_path / "result.json").write_text(text)
    keep_others_results("predict", tmp_path)
    keep_others_results("predict", tmp_path / "nowhere")

"""Jobs of a multirun: a folder for each, and which of them are done."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

WORDS = "THERMO_WORDS"
"""Environment variable: the words of the command line, as the processes of a launcher see them."""

READ = ("data", "cameras", "images", "masks")
"""Settings that name what a job reads."""

# Letters of a job's folder; file systems end at 255 bytes.
LONGEST_LABEL = 100


def job_folder(out: Path, overrides: Sequence[str], number: int) -> Path:
    """The folder of one job: only what differs between the jobs names it.

    Arguments: `overrides`: the job's words; `number`: of the job, where they are too long, or
    where the job runs on a machine that was not told the words of the command.
    """
    given = json.loads(os.environ.get(WORDS, "null"))
    swept = [] if given is None else [word for word in overrides if word not in given]
    # Equals signs, commas and brackets in a folder's name would need quotes in the next command.
    label = re.sub(r"(?:[^\w.+-]|_)+", "_", "_".join(swept).replace("=", "-")).strip("_")
    return out / (label if 0 < len(label) <= LONGEST_LABEL else str(number))


def _files(given: object) -> Iterable[Path]:
    """What a setting names: a file, or all in a folder."""
    if given is None:
        return ()
    path = Path(str(given))
    return path.iterdir() if path.is_dir() else (path,)


def finished(verb: str, settings: Mapping[str, Any]) -> bool:
    """Whether a job has left its result, with these settings and from the data as they are."""
    path = Path(str(settings["out"])) / "result.json"
    try:
        record = json.loads(path.read_text("utf-8"))
        written = path.stat().st_mtime
        data = [file.stat().st_mtime for key in READ for file in _files(settings.get(key))]
    except (OSError, ValueError):
        return False
    same = record.get("configuration") == json.loads(json.dumps(settings, default=str))
    return record.get("verb") == verb and same and max(data, default=written) <= written

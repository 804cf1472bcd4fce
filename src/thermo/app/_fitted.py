"""What a finished fit was asked and what it found, from the folder that it left."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from thermo.errors import InputError


@final
@dataclass(frozen=True)
class Fitted:
    """`runs` and `unknown` of a fit, and `values` by quantity, what was stated or a median [SI]."""

    runs: tuple[str, ...]
    unknown: tuple[str, ...]
    values: dict[str, float]


def read_fitted(folder: Path) -> Fitted:
    """The fit in a folder [SI].

    Raises `InputError` where there is no finished fit, or its record is damaged.
    """
    path = folder / "result.json"
    try:
        record = json.loads(path.read_text("utf-8"))
        return _fitted(record)
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise InputError(
            "this is no finished fit",
            where=str(path),
            value=f"{type(fault).__name__}: {fault}",
            limit="the result.json that `thermo invert` writes last",
            remedy="give the `out` folder of a finished `thermo invert` as `estimate`",
        ) from fault


def _fitted(record: dict[str, Any]) -> Fitted:
    if record["verb"] != "invert":
        raise ValueError(f"it is of thermo {record['verb']}")
    medians = {name: float(item["median"]) for name, item in record["fields"].items()}
    stated = record["configuration"]["initial"]
    given = {name: float(value) for name, value in stated.items() if value is not None}
    return Fitted(tuple(record["fit"]["rmse"]), tuple(medians), given | medians)

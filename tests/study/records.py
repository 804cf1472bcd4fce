"""Records as the cases of a study leave them."""

from __future__ import annotations

from typing import Any

import numpy as np

STARTS, SEEDS = (0.1, 10.0), (0, 1)


def made(row: str, **more: Any) -> dict[str, Any]:
    """A record of a fit of `row`, such as `cube-cooling`."""
    kind, _, process = row.partition("-")
    numbers = {"error": 0.01, "ratio": 1.0, "width": 0.02, "expected": 0.005, "rmse": 0.03}
    numbers |= {"width_by_median": 0.02, "final_mae": 0.004, "start": 1.0, "seed": 0}
    words = {"row": row, "object": kind, "process": process, "part": "tables"}
    words |= {"preset": "best", "noise": "none", "informed": True, "seconds": 9.0}
    return {**numbers, **words, "success": True, "step": None, **more}


def held_out(mae: float) -> dict[str, Any]:
    """Errors of both fields under both tests [K]."""
    errors = {kind: {"mae": mae, "rmse": 0.02, "max": 0.3} for kind in ("spatial", "median")}
    return {"warming": errors, "heating": errors}


def repeated(row: str) -> list[dict[str, Any]]:
    """Four fits of a row: a start of 10 ends one per cent higher than one of 0.1."""
    return [
        made(row, part="ensembles", start=start, seed=seed,
             ratio=float(np.exp(0.005 * np.log10(start))))
        for start in STARTS for seed in SEEDS
    ]  # fmt: skip

from __future__ import annotations

import numpy as np
import pytest

from thermo.report import table


def test_layout() -> None:
    rows = [["heating", 0.0512345, 12, True], ["cooling_long", np.float64(1234.5678), 3, None]]
    assert table(rows, ["run", "RMSE [K]", "n", "held out"]) == "\n".join(
        [
            "run           RMSE [K]   n  held out",
            "------------  --------  --  --------",
            "heating        0.05123  12  yes",
            "cooling_long      1235   3  -",
        ]
    )


def test_no_rows() -> None:
    assert table([], ["a", "bc"]) == "a  bc\n-  --"


def test_ragged_rows_are_refused() -> None:
    with pytest.raises(ValueError, match="a row of 1 cells under a header of 2"):
        table([["a"]], ["a", "b"])

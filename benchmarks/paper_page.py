"""Put the tables and figures of studies and of the spatial benchmark into docs/paper.md.

    python benchmarks/paper_page.py STUDY ...

Each STUDY is a folder that `thermo study paper` left; where two hold the same row the later one
counts. Tables of the page are replaced in place, CSV files go to benchmarks/results and figures to
docs/images.
"""

from __future__ import annotations

import csv
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"

# Columns of a table that tell its rows apart.
LABELS = {"recovery": 3, "transfer": 4, "processes": 3, "smoothness": 4, "ensembles": 3}
FIGURES = ("robustness-best-none.png", "transfer-best-none.png")


def merged(name: str, studies: list[Path]) -> list[list[str]]:
    """The rows of one table of all studies, its header first."""
    header, rows = [], {}
    for study in studies:
        path = study / f"{name}.csv"
        if path.exists():
            with path.open(newline="") as stream:
                header, *found = csv.reader(stream)
            rows |= {tuple(row[: LABELS[name]]): row for row in found}
    return [header, *rows.values()]


def markdown(path: Path) -> str:
    """A CSV file as a table in Markdown."""
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main() -> None:
    """Copy the files and fill the page."""
    if len(sys.argv) < 2:
        sys.exit("which studies? python benchmarks/paper_page.py FOLDER ...")
    studies = [Path(word) for word in sys.argv[1:]]
    for name in LABELS:
        rows = merged(name, studies)
        if len(rows) > 1:
            with (RESULTS / f"paper_{name}.csv").open("w", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows(rows)
    for figure in FIGURES:
        for study in studies:
            if (study / figure).exists():
                shutil.copy(study / figure, ROOT / "docs" / "images" / f"paper_{figure}")
    page = ROOT / "docs" / "paper.md"
    text = page.read_text("utf-8")
    for name in (*(f"paper_{table}" for table in LABELS), "paper_gap", "spatial"):
        if not (RESULTS / f"{name}.csv").exists():
            continue
        made = markdown(RESULTS / f"{name}.csv")
        mark = rf"(<!-- {name} -->\n).*?(\n?<!-- end -->)"
        text, count = re.subn(mark, lambda hit, made=made: hit[1] + made + hit[2], text, flags=re.S)
        if count != 1:
            sys.exit(f"{page}: no place for {name}")
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    main()

"""Put the tables of a study and of the spatial benchmark into docs/paper.md.

    python benchmarks/paper_page.py STUDY

STUDY is the folder that `thermo study paper` left. Tables of the page are replaced in place; CSV
files of the study are copied to benchmarks/results.
"""

from __future__ import annotations

import csv
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"


def markdown(path: Path) -> str:
    """A CSV file as a table in Markdown."""
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main() -> None:
    """Copy the files and fill the page."""
    if len(sys.argv) != 2:
        sys.exit("which study? python benchmarks/paper_page.py FOLDER")
    study = Path(sys.argv[1])
    for name in ("recovery", "transfer"):
        shutil.copy(study / f"{name}.csv", RESULTS / f"paper_{name}.csv")
    page = ROOT / "docs" / "paper.md"
    text = page.read_text("utf-8")
    for name in ("paper_recovery", "paper_transfer", "spatial"):
        made = markdown(RESULTS / f"{name}.csv")
        mark = rf"(<!-- {name} -->\n).*?(\n<!-- end -->)"
        text, count = re.subn(mark, lambda hit, made=made: hit[1] + made + hit[2], text, flags=re.S)
        if count != 1:
            sys.exit(f"{page}: no place for {name}")
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    main()

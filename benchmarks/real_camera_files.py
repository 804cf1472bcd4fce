"""What the readers make of real cameras' files, beside what another program makes of them.

Each radiometric file of a folder and of the folders in it is read as `thermo register` reads one.
Where a CSV of the same name lies beside it, one row a row of the picture in degrees Celsius, which
FLIR Tools and others export, the temperatures are compared pixel by pixel. A pixel is `missing`
where the file says that its temperature lies beyond what the camera tells; of those `unlike` are
the ones at which the other program does not show its own limit, the least or the largest of all its
values to 0.02 K. A file that is refused has the refusal in place of numbers.

    python benchmarks/real_camera_files.py FOLDER [--write]

The files of the committed table are public, and none of them is in this repository:

- `comparison_with_flir_tools` of gpereyrairujo/IRimage_paper: 26 pictures of FLIR cameras from
  Wikimedia Commons, 25 of them with the export of FLIR Tools from its `csv`
  (Pereyra Irujo, PeerJ Computer Science 8 (2022) e977);
- `MacOS/IRimage/test` of gpereyrairujo/IRimage: one more with such an export;
- `inst/extdata` of gtatters/Thermimage: one picture;
- `images` of SanNianYiSi/thermal_parser: FLIR's, one of which is among those of IRimage_paper, and
  DJI's of two kinds: with a core of FLIR, and in the format of DJI's own.

`tests/imaging/readers/test_real_camera_files.py` holds them to half of a thousandth where the
environment variable `THERMOFIELD_CAMERA_FILES` names such a folder.

With `--write` leaves benchmarks/results/real_camera_files.csv. Takes some ten seconds.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import read_frames

RESULTS = Path(__file__).resolve().parent / "results" / "real_camera_files.csv"
SUFFIXES = (".jpg", ".jpeg", ".is2", ".hcc")
ZERO = 273.15  # K, of 0 C
LIMIT = 0.02  # K
MAKER, MODEL = 0x010F, 0x0110
HEADER = (
    "file", "camera", "rows", "columns", "least_K", "median_K", "largest_K", "missing", "compared",
    "largest_difference_K", "mean_difference_K", "unlike", "refused",
)  # fmt: skip


def camera_of(file: Path) -> str:
    """Maker and model by the Exif data of a picture; empty without them."""
    try:
        with Image.open(file) as picture:
            exif = picture.getexif()
    except OSError:
        return ""
    words = (str(exif.get(tag, "")).split("\0")[0].strip() for tag in (MAKER, MODEL))
    return " ".join(word for word in words if word)


def exported(file: Path) -> np.ndarray | None:
    """Temperatures [K] that another program exported, (rows, columns); None without a file."""
    beside = file.with_suffix(".csv")
    if not beside.is_file():
        return None
    lines = [one.rstrip() for one in beside.read_text("utf-8-sig").splitlines() if one.strip()]
    separator = next(one for one in "\t;," if one in lines[0])
    if separator != ",":
        lines = [one.replace(",", ".") for one in lines]
    return np.loadtxt(lines, delimiter=separator) + ZERO


def row_of(file: Path, folder: Path) -> dict[str, object]:
    """What one file tells, as a row of the table."""
    row: dict[str, object] = dict.fromkeys(HEADER, "")
    row |= {"file": file.relative_to(folder).as_posix(), "camera": camera_of(file)}
    try:
        values = read_frames(file).values[0].astype(float)
    except InputError as error:
        return row | {"refused": f"{error.what}: {error.value}"}
    told = np.isfinite(values)
    row |= {"rows": values.shape[0], "columns": values.shape[1], "missing": int((~told).sum())}
    for name, level in (("least_K", 0), ("median_K", 50), ("largest_K", 100)):
        row[name] = f"{np.percentile(values[told], level):.3f}"
    other = exported(file)
    if other is None:
        return row
    if other.shape != values.shape:
        return row | {"refused": f"the export is of shape {other.shape}"}
    off = (values - other)[told]
    ends = (other < other.min() + LIMIT) | (other > other.max() - LIMIT)
    return row | {
        "compared": off.size,
        "largest_difference_K": f"{np.abs(off).max():.5f}",
        "mean_difference_K": f"{off.mean():.6f}",
        "unlike": int((~told & ~ends).sum()),
    }


def line(row: dict[str, object]) -> str:
    """A row for people."""
    said = f"{row['file']} ({row['camera']}): "
    if row["refused"]:
        return f"{said}refused: {row['refused']}"
    said += f"{row['rows']} x {row['columns']}, {row['least_K']} / {row['median_K']} / "
    said += f"{row['largest_K']} K, {row['missing']} missing"
    if row["compared"] == "":
        return said
    return (
        f"{said}; {row['compared']} compared, off by {row['largest_difference_K']} K at most and "
        f"{row['mean_difference_K']} K in the mean, {row['unlike']} missing here alone"
    )


def summary(rows: list[dict[str, object]]) -> str:
    """How many files were read, and how far off the worst of the compared pixels is."""
    read = [row for row in rows if not row["refused"]]
    compared = [row for row in read if row["compared"] != ""]
    said = f"{len(read)} of {len(rows)} files read, {len(compared)} compared"
    if compared:
        worst = max(float(str(row["largest_difference_K"])) for row in compared)
        pixels = sum(int(str(row["compared"])) for row in compared)
        said += f": {pixels} pixels, off by {worst:.5f} K at most"
    return said


def main() -> None:
    """Read, compare, print and, where asked for, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true", help=f"write {RESULTS.name}")
    asked = parser.parse_args()
    files = sorted(one for one in asked.folder.rglob("*") if one.suffix.casefold() in SUFFIXES)
    if not files:
        sys.exit(f"no file in {asked.folder} ends in one of {', '.join(SUFFIXES)}")
    rows = []
    for file in files:
        rows.append(row_of(file, asked.folder))
        print(line(rows[-1]), flush=True)
    print(summary(rows))
    if asked.write:
        with RESULTS.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, HEADER, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()

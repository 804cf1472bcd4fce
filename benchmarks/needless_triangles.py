"""What the mesher's simplification costs and gains where a surface has needless triangles.

    python benchmarks/needless_triangles.py

A flat face may be cut in thousands of triangles. The mesher can take off what it does not need
before it begins, or leave that to its passes: `thermo.mesh._tetrahedralise.NEEDLESS` says from
which share of needless vertices on it is left. Both ways for bricks, a cylinder cut more finely
than it is round, the bracket and a ball: triangles, share of needless vertices, seconds of
processor time, nodes, and the least and median quality of cells. Writes
benchmarks/results/needless_triangles.csv.
"""

from __future__ import annotations

import csv
import resource
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from thermo.mesh import Surface, cell_quality, read_surface, sizing_from_physics, tetrahedralise
from thermo.mesh import _tetrahedralise as mesher
from thermo.mesh._needless import needless_share

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results" / "needless_triangles.csv"
COLUMNS = ("body", "triangles", "needless", "simplified", "seconds", "nodes", "least", "median")
NODES = 5000


def bodies() -> dict[str, Surface]:
    """Surfaces by name [m]."""
    box = trimesh.creation.box([0.06, 0.04, 0.02])
    tube = trimesh.creation.cylinder(0.02, 0.03, sections=48)
    found = {
        "brick": box,
        "brick, 768": cut(box, 3),
        "brick, 3072": cut(box, 4),
        "brick, 12288": cut(box, 5),
        "cylinder": cut(tube, 2),
        "ball": trimesh.creation.icosphere(4, 0.02),
    }
    read = {
        name: Surface(np.array(one.vertices), np.array(one.faces)) for name, one in found.items()
    }
    return {**read, "bracket": read_surface(HERE.parent / "examples/bracket/surface.ply", unit="m")}


def cut(body: trimesh.Trimesh, times: int) -> trimesh.Trimesh:
    """The body with each triangle cut in four so often."""
    for _ in range(times):
        body = body.subdivide()
    return body


def main() -> None:
    """Mesh each body both ways, print and write."""
    rows = []
    for name, surface in bodies().items():
        sizing = sizing_from_physics(surface, diffusivity=5e-7, duration=60.0, max_nodes=NODES)
        share = needless_share(surface)
        for simplified in (True, False):
            mesher.NEEDLESS = 2.0 if simplified else 0.0  # pyright: ignore[reportConstantRedefinition]
            began = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            with tempfile.TemporaryDirectory() as folder:
                mesh = tetrahedralise(surface, sizing, cache=Path(folder))
            took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - began
            quality = cell_quality(mesh)
            rows.append((
                name, len(surface.triangles), f"{share:.3f}", "yes" if simplified else "no",
                f"{took:.3g}", len(mesh.nodes), f"{quality.min():.2f}",
                f"{np.median(quality):.2f}",
            ))  # fmt: skip
            print(*rows[-1], flush=True)
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


if __name__ == "__main__":
    main()

"""How much less than its surface the meshes of a fit hold, and the finer ones that correct it.

    python benchmarks/mesh_volumes.py SCENES [NAME ...]

A body of too little volume heats up too fast, and its capacity comes out too high. The mesher's
faces lie within a curved surface; `tetrahedralise` moves them out. Prints by scene and mesh the
nodes, and the volume and the area over the surface's, less one.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from thermo.inverse import FINER, Meshing
from thermo.inverse._body import make_mesh, surface_of
from thermo.observe import read_scene

NAMES = ("cube", "cylinder", "sphere", "bear", "bunny")


def main() -> None:
    """Mesh each scene as a fit does, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("names", nargs="*", default=NAMES)
    asked = parser.parse_args()
    for name in asked.names:
        folder = asked.scenes / name
        scene = read_scene(folder)
        surface = surface_of(scene)
        truth = json.loads((folder / "scene.json").read_text("utf-8"))["truth"]
        for finer in (1.0, FINER):
            mesh = make_mesh(scene, surface, truth["diffusivity"], Meshing(), finer=finer)
            volume = 100 * (mesh.volume() / surface.volume() - 1)
            area = 100 * (mesh.area() / surface.area() - 1)
            words = f"volume {volume:.3f} %, area {area:.3f} %"
            print(f"{name}, {len(mesh.nodes)} nodes: {words}", flush=True)


if __name__ == "__main__":
    main()

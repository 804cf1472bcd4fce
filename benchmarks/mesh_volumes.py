"""How much less than its surface the meshes of a fit hold, and the finer ones that correct it.

    python benchmarks/mesh_volumes.py SCENES [NAME ...]

Corners of a mesh lie on a curved surface and its flat faces within: a body of too little volume
heats up too fast, and its capacity comes out too high. Prints by scene and mesh the nodes, and the
volume and the area over the surface's, less one.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from thermo.inverse import FINER, Meshing
from thermo.inverse._body import make_mesh, surface_of
from thermo.observe import read_scene

NAMES = ("cube", "cylinder", "sphere", "bear", "bunny")


def enclosed(
    nodes: Float[np.ndarray, "nodes 3"], faces: Int[np.ndarray, "faces 3"]
) -> tuple[float, float]:
    """Volume [m3] and area [m2] of a closed surface whose faces look outwards."""
    first, second, third = nodes[faces].swapaxes(0, 1)
    turned = np.cross(second - first, third - first)
    return float(np.sum(first * turned) / 6), float(np.linalg.norm(turned, axis=1).sum() / 2)


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
        wanted = enclosed(surface.vertices, surface.triangles)
        truth = json.loads((folder / "scene.json").read_text("utf-8"))["truth"]
        for finer in (1.0, FINER):
            mesh = make_mesh(scene, surface, truth["diffusivity"], Meshing(), finer=finer)
            found = enclosed(mesh.nodes, mesh.faces[:, :3])
            volume, area = (
                f"{100 * (mine / its - 1):.3f} %" for mine, its in zip(found, wanted, strict=True)
            )
            print(f"{name}, {len(mesh.nodes)} nodes: volume {volume}, area {area}", flush=True)


if __name__ == "__main__":
    main()

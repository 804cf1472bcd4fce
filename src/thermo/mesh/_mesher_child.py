"""What the mesher's own process runs: pytetwild on arrays from a file.

It is started by `tetrahedralise` with a temporary working directory, because the mesher writes a
stray file there, cannot be interrupted and may end the process. It imports nothing of `thermo`.
"""

from __future__ import annotations

import sys
from types import ModuleType


def main(source: str, target: str) -> None:
    """Read the surface and the sizing field from `source`, write nodes and cells to `target`."""
    # pytetwild 0.4 imports pyvista, an optional dependency, for an accessor that is not used here.
    sys.modules.setdefault("pyvista", ModuleType("pyvista"))
    import numpy as np
    from pytetwild.pytetwild import tetrahedralize

    with np.load(source, allow_pickle=False) as given:
        nodes, cells = tetrahedralize(
            given["vertices"],
            given["triangles"],
            edge_length_abs=float(given["edge"]),
            epsilon=float(given["epsilon"]),
            stop_energy=float(given["stop_energy"]),
            num_opt_iter=int(given["passes"]),
            simplify=bool(given["simplify"]),
            coarsen=bool(given["coarsen"]),
            vtk_ordering=True,
            quiet=True,
            bg_vertices=given["field_nodes"],
            bg_tets=given["field_cells"],
            bg_values=given["field_values"],
        )
    np.savez(target, nodes=nodes, cells=cells)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])

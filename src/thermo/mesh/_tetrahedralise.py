"""Tetrahedra from a surface, by pytetwild."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError

from . import _mesher_child
from ._cache import READING, content_key, default_cache, load_cells, save_cells
from ._conform import conformed
from ._gate import gated_mesh, sound_mesh
from ._geometry import squared_edges
from ._mesh import Mesh
from ._needless import needless_share
from ._simplify import simplified
from ._sizing import Fine, Sizing
from ._sizing_field import sizing_field
from ._surface import Surface

MOST_TRIANGLES: Final = 40000
"""Largest surface that is given to the mesher; its time grows steeply beyond."""

TARGET: Final = 20000
"""Triangles that a finer surface is brought down to."""

STOP_ENERGY: Final = 30.0
"""AMIPS energy at which the mesher is content; 10 takes twice as long for no gain that matters."""

PASSES: Final = 20
"""Most optimisation passes of the mesher; later ones take long and change little."""

ASK: Final = 1.0
"""Edge lengths asked for, over those wanted: the mesher's edges come out longer."""

LONGER: Final = 2.2
"""Mean edge over the one wanted where it is to be short, from which the mesher is asked again: it
ends once cells are well shaped, which may be long before they are small in few places."""

AGAIN: Final = 0.6
"""The short edge that is asked for then, over the one before."""

DENSER: Final = 0.7
"""The same of the longest one, by which the mesher spreads the points that it begins with."""

NEEDLESS: Final = 0.5
"""Share of needless vertices from which the mesher does not take them off before it begins: within
flat faces it looks all along ever longer triangles, often for longer than it makes the mesh, which
comes out alike without (`benchmarks/needless_triangles.py`). Elsewhere that saves it time."""

ASKED: Final = 4
"""How often the mesher is asked at the most."""


def tetrahedralise(
    surface: Surface,
    sizing: Sizing,
    *,
    cache: Path | None = None,
    time_limit: float = 600.0,
    where: str = "surface",
) -> Mesh:
    """Fill a checked surface with linear tetrahedra (TET4).

    The mesher is fTetWild (Hu, Schneider, Wang, Zorin, Panozzo, ACM Trans. Graph. 39 (2020) 117);
    its surface stays within the tolerance of the given one, and is then moved so that the mesh
    holds as much, see `conformed`. The mesher is not reproducible, so the result is kept in a
    cache under a hash of the surface, the sizing and the versions. It runs in a process and a
    folder of its own, and leaves nothing behind.

    Arguments:
    - `surface`: closed and turned outward, see `check_surface` [m].
    - `sizing`: wanted edge lengths [m].
    - `cache`: folder for meshes; `thermofield/meshes` in the user's cache where left out.
    - `time_limit`: longest time for the mesher [s].
    - `where`: what to call the surface in messages.

    Raises `InputError` for a surface that is too fine to mesh, when the mesher fails or takes too
    long, and when its mesh is not good enough.
    """
    folder = default_cache() if cache is None else Path(cache)
    again = (LONGER, AGAIN, DENSER, ASKED) if sizing.fine else ()
    entry = folder / f"{content_key(surface, sizing, (STOP_ENERGY, PASSES, ASK, *again))}.npz"
    kept = load_cells(entry)
    if kept is not None:
        try:
            return gated_mesh(*kept, surface, where=where)
        except InputError:
            # An entry that no longer passes is as good as none.
            entry.unlink(missing_ok=True)
    fewer = simplified(surface, most=MOST_TRIANGLES, target=TARGET, where=where)
    nodes, cells = _small_enough(fewer, sizing, time_limit, where)
    made = sound_mesh(nodes, cells, where=where)
    mesh = gated_mesh(conformed(made, surface), made.cells, surface, where=where)
    save_cells(entry, mesh.nodes, mesh.cells)
    # What is kept may be another process's mesh; fits that run side by side then share it.
    kept = load_cells(entry)
    return mesh if kept is None else gated_mesh(*kept, surface, where=where)


def _small_enough(
    surface: Surface, sizing: Sizing, time_limit: float, where: str
) -> tuple[Float[np.ndarray, "nodes 3"], Int[np.ndarray, "cells 4"]]:
    """Nodes [m] and cells of the mesher, asked again where few cells are to be small and are not.

    Of several meshes the one with the smallest cells there.
    """
    asked, meshes, longer = sizing, [], []
    for trial in range(ASKED):
        longest = ASK * sizing.core * DENSER**trial
        nodes, cells = _run_mesher(surface, asked, longest, time_limit, where)
        meshes.append((nodes, cells))
        longer.append(max((_edge_over(nodes, cells, one) for one in sizing.fine), default=0.0))
        if longer[-1] <= LONGER:
            break
        fine = tuple(Fine(one.points, AGAIN * one.edge) for one in asked.fine)
        asked = replace(asked, fine=fine)
    return meshes[int(np.argmin(longer))]


def _edge_over(nodes: np.ndarray, cells: np.ndarray, fine: Fine) -> float:
    """Mean edge of the cells that lie nearest to where it is to be short, over that length [1]."""
    nearest = KDTree(nodes[cells].mean(axis=1)).query(fine.points)[1]
    return float(np.sqrt(squared_edges(nodes, cells[nearest])).mean() / fine.edge)


def _run_mesher(
    surface: Surface, sizing: Sizing, longest: float, time_limit: float, where: str
) -> tuple[Float[np.ndarray, "nodes 3"], Int[np.ndarray, "cells 4"]]:
    """Run pytetwild in a process of its own inside a temporary folder.

    `longest`: edge that it is told to make where nothing shorter is wanted [m].
    """
    field_nodes, field_cells, field_values = sizing_field(surface, sizing)
    with tempfile.TemporaryDirectory(prefix="thermofield-") as name:
        source, target = Path(name) / "surface.npz", Path(name) / "mesh.npz"
        np.savez(
            source,
            vertices=surface.vertices,
            triangles=surface.triangles.astype(np.int32),
            edge=longest,
            epsilon=sizing.envelope(surface) / surface.diagonal(),
            stop_energy=STOP_ENERGY,
            passes=PASSES,
            simplify=needless_share(surface) < NEEDLESS,
            coarsen=True,
            field_nodes=field_nodes,
            field_cells=field_cells,
            field_values=ASK * field_values,
        )
        command = [sys.executable, _mesher_child.__file__, str(source), str(target)]
        try:
            done = subprocess.run(
                command, cwd=name, capture_output=True, text=True, timeout=time_limit, check=False
            )
        except subprocess.TimeoutExpired as late:
            raise InputError(
                "the mesher did not finish",
                where=where,
                value=f"stopped after {time_limit:g} s",
                limit=f"{time_limit:g} s",
                remedy="coarsen the sizing or simplify the surface",
            ) from late
        if done.returncode != 0 or not target.exists():
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise InputError(
                "the mesher failed",
                where=where,
                value=f"exit {done.returncode}: {last[:200]}",
                limit="a mesh",
                remedy="repair the surface, or mesh it elsewhere and use mesh_from_cells",
            )
        with READING, np.load(target, allow_pickle=False) as made:
            return made["nodes"], made["cells"]

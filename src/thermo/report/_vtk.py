"""Files for ParaView: VTU for one state of a mesh, PVD for a series of them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path

import meshio
import numpy as np
from jaxtyping import Float, Int, Num

from thermo.observe import write_whole

_CELL_TYPES = {4: "tetra", 10: "tetra10"}


def _checked(data: Mapping[str, Num[np.ndarray, "..."]], count: int, what: str) -> dict:
    for name, array in data.items():
        if array.shape[:1] != (count,):
            raise ValueError(f"{name}: {array.shape} does not hold one value for {count} {what}")
    return {name: np.ascontiguousarray(array) for name, array in data.items()}


def write_vtu(
    path: Path,
    nodes: Float[np.ndarray, "nodes 3"],
    cells: Int[np.ndarray, "cells corners"],
    point_data: Mapping[str, Num[np.ndarray, "..."]] | None = None,
    cell_data: Mapping[str, Num[np.ndarray, "..."]] | None = None,
) -> None:
    """Writes a mesh with values at its nodes and in its cells as VTU, whole or not at all.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `nodes`: positions [m], (n, 3).
    - `cells`: nodes of each tetrahedron, (c, 4), or (c, 10) with the middles of the edges
      01 12 02 03 13 23, which is VTK's order.
    - `point_data`: by name, one number or vector for each node, in SI units. Put the unit into
      the name: `temperature [K]`.
    - `cell_data`: the same for each cell.

    Raises `ValueError` where the number of values or of corners does not fit.
    """
    if cells.shape[1] not in _CELL_TYPES:
        raise ValueError(f"a tetrahedron has 4 or 10 nodes, not {cells.shape[1]}")
    mesh = meshio.Mesh(
        nodes,
        [(_CELL_TYPES[cells.shape[1]], np.asarray(cells, dtype=np.int64))],
        point_data=_checked(point_data or {}, len(nodes), "nodes"),
        cell_data={n: [v] for n, v in _checked(cell_data or {}, len(cells), "cells").items()},
    )
    with write_whole(path) as temporary:
        meshio.write(temporary, mesh, file_format="vtu")


def write_pvd(
    path: Path,
    times: Sequence[float] | Float[np.ndarray, " frames"],
    vtu_names: Sequence[str],
) -> None:
    """Writes the list that ParaView opens as a series in time, whole or not at all.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `times`: the time of each state [s], (t,).
    - `vtu_names`: the file of each state, relative to the folder of `path`, (t,).

    Raises `ValueError` where the two differ in length.
    """
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for time, name in zip(times, vtu_names, strict=True):
        ElementTree.SubElement(
            collection, "DataSet", timestep=repr(float(time)), group="", part="0", file=name
        )
    ElementTree.indent(root)
    with write_whole(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)

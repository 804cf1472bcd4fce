"""DOLFINx on a problem of the comparison; prints one line of JSON.

    PYTHON dolfinx_loop.py forward --reference FILE

PYTHON has dolfinx 0.5 and petsc4py with real numbers: the system's on Debian 12, where
python3-dolfinx is installed.

What does not change is assembled before the clock runs; a step adds radiation to a copy of it and
solves by conjugate gradients with the diagonal, from an extrapolation of the last two temperatures.
"""

from __future__ import annotations

import os
import tempfile
import time

for name in ("NPROC", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
# Compiled forms are kept there: an empty folder makes the seconds of compiling a new machine's.
FRESH = tempfile.TemporaryDirectory()
os.environ["XDG_CACHE_HOME"] = FRESH.name

import dolfinx  # noqa: E402
import numpy as np  # noqa: E402
import ufl  # noqa: E402
from dolfinx import fem  # noqa: E402
from mpi4py import MPI  # noqa: E402
from peer_problem import Given, arguments, report  # noqa: E402
from petsc4py import PETSc  # noqa: E402
from scipy.spatial import KDTree  # noqa: E402
from timing import clock, peak_gb  # noqa: E402

RTOL = 1e-10
"""Of a linear solve, against the right-hand side, as in the SciPy loop beside it."""


class Loop:
    """One problem, assembled."""

    def __init__(self, given: Given) -> None:
        self.given = given
        straight = ufl.VectorElement("Lagrange", "tetrahedron", 1)
        cells = given.cells.astype(np.int64)
        body = dolfinx.mesh.create_mesh(MPI.COMM_SELF, cells, given.nodes, ufl.Mesh(straight))
        begun = time.perf_counter()
        space = fem.FunctionSpace(body, ("Lagrange", 1))
        self.old = fem.Function(space)
        conductivity = fem.Function(fem.FunctionSpace(body, ("DG", 0)))
        # The library numbers cells anew, and nodes.
        conductivity.x.array[:] = given.conductivity[body.topology.original_cell_index]
        mass, constant, self.radiating, self.load = self._forms(body, space, conductivity)
        self.compiling = time.perf_counter() - begun
        places = space.tabulate_dof_coordinates()
        self.surface = KDTree(places).query(given.nodes[given.surface])[1]
        self.mass, self.constant = (fem.petsc.assemble_matrix(form) for form in (mass, constant))
        self.mass.assemble()
        self.constant.assemble()
        self.matrix = self.constant.copy()
        self.right = fem.petsc.create_vector(self.load)
        self.content = self.right.duplicate()
        self.solver = PETSc.KSP().create(MPI.COMM_SELF)
        self.solver.setType("cg")
        self.solver.getPC().setType("jacobi")
        self.solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        self.solver.setTolerances(rtol=RTOL)
        self.solver.setInitialGuessNonzero(True)

    def _forms(
        self, body: dolfinx.mesh.Mesh, space: fem.FunctionSpace, conductivity: fem.Function
    ) -> list:
        """Compiled: mass, all that is constant, radiation, and the right-hand side's surface."""
        given, old = self.given, self.old
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        inside = ufl.Measure("dx", body, metadata={"quadrature_degree": 2})
        rim = ufl.Measure("ds", body, metadata={"quadrature_degree": 2})
        mass = given.capacity / given.size * u * v * inside
        conduction = conductivity * ufl.dot(ufl.grad(u), ufl.grad(v)) * inside
        radiated = given.radiating * (given.surroundings**4 + 3 * old**4)
        return fem.form([
            mass,
            mass + conduction + given.convection * u * v * rim,
            4 * given.radiating * old**3 * u * v * rim,
            (given.convection * given.surroundings + radiated) * v * rim,
        ])  # fmt: skip

    def forward(self) -> np.ndarray:
        """Surface temperatures [K] after each step, (steps, surface nodes)."""
        old = self.old.x.array
        old[:] = self.given.start
        before = old.copy()
        kept = np.empty((self.given.steps, len(self.surface)))
        for step in range(self.given.steps):
            self.constant.copy(self.matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
            fem.petsc.assemble_matrix(self.matrix, self.radiating)
            self.matrix.assemble()
            self.right.set(0.0)
            fem.petsc.assemble_vector(self.right, self.load)
            self.mass.mult(self.old.vector, self.content)
            self.right.axpy(1.0, self.content)
            before, old[:] = old.copy(), 2 * old - before
            self.solver.setOperators(self.matrix)
            self.solver.solve(self.right, self.old.vector)
            kept[step] = old[self.surface]
        return kept


def main() -> None:
    """Measure once."""
    imported = peak_gb()
    given, task = arguments("DOLFINx on one problem.", ("forward",))
    loop = Loop(given)
    loop.forward()
    found, cpu, wall = clock(loop.forward)
    report(
        given, "dolfinx", task, found,
        cpu_s=cpu, wall_s=wall, compile_s=loop.compiling, base_gb=imported, rtol=RTOL,
    )  # fmt: skip


if __name__ == "__main__":
    main()

"""JAX-FEM on a problem of the comparison; prints one line of JSON.

    PYTHON jax_fem_loop.py forward|gradient --reference FILE

PYTHON has jax-fem 0.0.11 and petsc4py with real numbers: on Debian 12 a virtual environment of the
system's Python with `"numpy<2" "scipy<1.16" jax==0.6.2 fenics-basix meshio gmsh pyfiglet matplotlib
jax-fem==0.0.11`, and the folder of python3-petsc4py-real in a .pth file.

PETSc's conjugate gradients with incomplete factors are as fast as any of its solvers here, since
most of the time goes into assembly. A step is linear, so that one update of its Newton loop
suffices; that loop assembles before the update and once more after it.
"""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable

for name in ("NPROC", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from jax_fem.generate_mesh import Mesh  # noqa: E402
from jax_fem.problem import Problem  # noqa: E402
from jax_fem.solver import ad_wrapper, solver  # noqa: E402
from peer_problem import Given, arguments, report  # noqa: E402
from petsc4py import PETSc  # noqa: E402
from timing import clock, peak_gb  # noqa: E402

RTOL = 1e-7
"""Of a linear solve, against the residual at the old temperature."""
ENOUGH = 1e-5
"""Residual after which the Newton loop stops: far above RTOL, so that it never updates twice."""
WARM = 2
"""Steps of the first call: the second is the first one that starts from a result."""


class Heat(Problem):
    """One implicit Euler step; its parameters are conductivity and old temperature."""

    def custom_init(self, given: Given) -> None:
        """Called by the library with what it was given as `additional_info`."""
        self.given = given
        if len(self.boundary_inds_list[0]) != len(given.faces):
            # Faces are chosen by their nodes, which cannot tell these from the boundary.
            raise SystemExit(f"{given.name}: inner faces have all their nodes on the surface")

    def get_tensor_map(self) -> Callable:
        """Conduction."""
        return lambda slope, old, conductivity: conductivity * slope

    def get_mass_map(self) -> Callable:
        """Heat content."""
        rate = self.given.capacity / self.given.size
        return lambda new, place, old, conductivity: rate * (new - old)

    def get_surface_maps(self) -> list[Callable]:
        """Convection, and radiation linearised at the old temperature."""
        given = self.given
        away = given.convection * given.surroundings + given.radiating * given.surroundings**4

        def leaving(new: jax.Array, place: jax.Array, old: jax.Array) -> jax.Array:
            radiated = given.radiating * old**3 * (4 * new - 3 * old)
            return given.convection * new + radiated - away

        return [leaving]

    def set_params(self, params: tuple[jax.Array, jax.Array]) -> None:
        """Values at the quadrature points, as the library asks for them."""
        conductivity, old = params
        cell, shape = self.cells_list_face_list[0][0], self.selected_face_shape_vals[0]
        points = self.fes[0].num_quads
        self.internal_vars = [
            self.fes[0].convert_from_dof_to_quad(old),
            jnp.repeat(conductivity[:, None], points, axis=1),
        ]
        self.internal_vars_surfaces = [[jnp.einsum("fqa,fav->fqv", shape, old[cell])]]


class Loop:
    """One problem, set up."""

    def __init__(self, given: Given) -> None:
        self.given = given
        rim = np.zeros(len(given.nodes), bool)
        rim[given.surface] = True
        on_surface = jnp.asarray(rim)
        # The default rule has one point, which does not integrate the mass.
        self.problem = Heat(
            Mesh(given.nodes, given.cells), vec=1, dim=3, ele_type="TET4", gauss_order=2,
            location_fns=[lambda place, node: on_surface[node]], additional_info=(given,),
        )  # fmt: skip
        PETSc.Options()["ksp_rtol"] = RTOL
        linear = {"petsc_solver": {"ksp_type": "cg", "pc_type": "ilu"}}
        self.options = {**linear, "tol": 0.0, "rel_tol": ENOUGH}
        self.step = ad_wrapper(self.problem, self.options, dict(linear))
        self.start = jnp.full((len(given.nodes), 1), given.start)
        self.conductivity = jnp.asarray(given.conductivity)

    def forward(self, steps: int) -> np.ndarray:
        """Surface temperatures [K] after each step, (steps, surface nodes)."""
        old, kept = self.start, []
        for _ in range(steps):
            self.problem.set_params((self.conductivity, old))
            self.options["initial_guess"] = [old]
            old = solver(self.problem, self.options)[0]
            kept.append(np.asarray(old)[self.given.surface, 0])
        return np.array(kept)

    def gradient(self, steps: int) -> np.ndarray:
        """Derivative [K2 per W/m/K] of the mean squared misfit by each cell's conductivity."""
        target, surface = jnp.asarray(self.given.target[:steps]), self.given.surface

        def misfit(conductivity: jax.Array) -> jax.Array:
            old, total = self.start, jnp.zeros(())
            for aim in target:
                self.options["initial_guess"] = [jax.lax.stop_gradient(old)]
                old = self.step((conductivity, old))[0]
                total += ((old[surface, 0] - aim) ** 2).sum()
            return total / target.size

        return np.asarray(jax.grad(misfit)(self.conductivity))


def main() -> None:
    """Measure once."""
    imported = peak_gb()
    logging.getLogger("jax_fem").setLevel(logging.WARNING)
    given, task = arguments("JAX-FEM on one problem.", ("forward", "gradient"))
    loop = Loop(given)
    function = loop.forward if task == "forward" else loop.gradient
    begun = time.perf_counter()
    function(WARM)
    first = time.perf_counter() - begun
    found, cpu, wall = clock(function, given.steps)
    compiling = max(first - WARM * wall / given.steps, 0.0)
    report(
        given, "jax-fem", task, found,
        cpu_s=cpu, wall_s=wall, compile_s=compiling, base_gb=imported, rtol=RTOL,
    )  # fmt: skip


if __name__ == "__main__":
    main()

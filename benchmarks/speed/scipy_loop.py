"""The loop that a competent engineer writes with SciPy, and its adjoint by hand.

Conjugate gradients with the diagonal on CSR, each solve from an extrapolation of the last two
temperatures, to 1e-10 of the right-hand side. Only the entries of the surface are written anew in
a step. Matrices come from scikit-fem, assembled before the clock runs.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import skfem
from problem import CONVECTION, EMISSIVITY, SIZE, Problem
from skfem.helpers import dot, grad

from thermo.physics.effects import STEFAN_BOLTZMANN

RADIATING = EMISSIVITY * STEFAN_BOLTZMANN


class Loop:
    """One problem, assembled."""

    def __init__(self, problem: Problem, rtol: float = 1e-10) -> None:
        self.problem, self.rtol = problem, rtol
        corners = np.unique(problem.mesh.cells[:, :4])
        number = np.full(len(problem.mesh.nodes), -1)
        number[corners] = np.arange(len(corners))
        points = np.ascontiguousarray(problem.mesh.nodes[corners].T)
        body = skfem.MeshTet(points, np.ascontiguousarray(number[problem.mesh.cells[:, :4]].T))
        quadratic = problem.mesh.order == 2
        element = skfem.ElementTetP2() if quadratic else skfem.ElementTetP1()
        basis = skfem.Basis(body, element, intorder=2 * problem.mesh.order)
        rim = skfem.FacetBasis(body, element, intorder=2 * problem.mesh.order)
        self.places = basis.doflocs.T
        self._pattern(basis)
        self._surface(rim)

    def _pattern(self, basis: skfem.Basis) -> None:
        """The sparsity, the place of each cell's entries in it, and the matrices of mass."""
        stiffness = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).elemental(basis)
        mass = skfem.BilinearForm(lambda u, v, w: u * v).elemental(basis)
        # A coarse renumbering would favour nobody: reverse Cuthill-McKee serves both.
        plain = mass.tocsr()
        order = sp.csgraph.reverse_cuthill_mckee(plain, symmetric_mode=True)
        self.place = np.empty(len(order), int)
        self.place[order] = np.arange(len(order))
        dofs = self.place[basis.element_dofs]
        count, width = plain.shape[0], len(dofs)
        rows = np.repeat(dofs.T, width, axis=1).ravel()
        columns = np.tile(dofs.T, (1, width)).ravel()
        pattern = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count))
        pattern.sort_indices()
        self.indptr, self.indices, self.count = pattern.indptr, pattern.indices, count
        own = np.repeat(np.arange(count), np.diff(pattern.indptr))
        self.key = own.astype(np.int64) * count + pattern.indices
        self.slot = self._find(rows, columns)
        # (cells, width, width), with the cells first in both numberings.
        self.stiffness = np.moveaxis(stiffness.data.reshape(width, width, -1), -1, 0)
        content = np.moveaxis(mass.data.reshape(width, width, -1), -1, 0)
        self.mass = self._add(content * self.problem.capacity / SIZE)
        self.mass_matrix = self._matrix(self.mass)
        self.diagonal = self._find(np.arange(count), np.arange(count))
        upper = np.flatnonzero(own < pattern.indices)
        self.first, self.second, self.upper = own[upper], pattern.indices[upper], upper

    def _surface(self, rim: skfem.FacetBasis) -> None:
        """Values at the quadrature points of the surface, and the entries that they change."""
        dofs = self.place[rim.element_dofs]
        shape = np.array([np.broadcast_to(u[0].value, rim.dx.shape) for u in rim.basis])
        faces, points = rim.dx.shape
        used = [a for a in range(len(dofs)) if np.abs(shape[a]).max() > 0]
        row = np.arange(faces * points)
        entries = [(shape[a].ravel(), row, np.repeat(dofs[a], points)) for a in used]
        value, at, node = (np.concatenate(part) for part in zip(*entries, strict=True))
        keep = np.abs(value) > 1e-14
        size = (faces * points, self.count)
        self.at_points = sp.csr_matrix((value[keep], (at[keep], node[keep])), shape=size)
        self.to_nodes = self.at_points.T.tocsr()
        self.weight = rim.dx.ravel()
        # From weighted coefficients at the points to the entries of the surface matrix.
        pairs = [(a, b) for a in used for b in used]
        value = np.concatenate([(shape[a] * shape[b]).ravel() for a, b in pairs])
        slot = np.concatenate(
            [np.repeat(self._find(dofs[a], dofs[b], missing=-1), points) for a, b in pairs]
        )
        at = np.tile(row, len(pairs))
        keep = (np.abs(value) > 1e-14) & (slot >= 0)
        self.surface_slot, place = np.unique(slot[keep], return_inverse=True)
        shape = (len(self.surface_slot), faces * points)
        self.to_entries = sp.csr_matrix((value[keep], (place, at[keep])), shape=shape)
        self.nodes = np.unique(self.at_points.indices)
        away = self.problem.surroundings
        self.load = self.to_nodes @ (self.weight * (CONVECTION * away + RADIATING * away**4))
        self.lamp = self._lamp(rim)

    def _lamp(self, rim: skfem.FacetBasis) -> np.ndarray | None:
        """Heat [W] of the lamp at each node, spread as a Gaussian over what faces it."""
        lamp = self.problem.lamp
        if lamp is None:
            return None
        place = np.moveaxis(np.asarray(rim.global_coordinates()), 0, -1)
        normal = np.moveaxis(np.asarray(rim.normals), 0, -1)
        axis = lamp.direction / np.linalg.norm(lamp.direction)
        offset = place - lamp.centre
        across = offset - (offset @ axis)[..., None] * axis
        share = np.exp(-(across**2).sum(-1) / (2 * lamp.radius**2)) * np.maximum(-normal @ axis, 0)
        spread = share.ravel() * self.weight
        return lamp.power * (self.to_nodes @ spread) / spread.sum()

    def _find(self, rows: np.ndarray, columns: np.ndarray, missing: int | None = None):
        key = rows.astype(np.int64) * self.count + columns
        place = np.minimum(np.searchsorted(self.key, key), len(self.key) - 1)
        return place if missing is None else np.where(self.key[place] == key, place, missing)

    def _add(self, terms: np.ndarray) -> np.ndarray:
        return np.bincount(self.slot, terms.ravel(), len(self.key))

    def _matrix(self, data: np.ndarray) -> sp.csr_matrix:
        return sp.csr_matrix((data, self.indices, self.indptr), shape=(self.count, self.count))

    def _constant(self, conductivity: np.ndarray) -> np.ndarray:
        data = self.mass + self._add(conductivity[:, None, None] * self.stiffness)
        data[self.surface_slot] += self.to_entries @ (CONVECTION * self.weight)
        return data

    def _step(self, constant: np.ndarray, old: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Entries of the step's matrix, and what radiation adds to the right-hand side."""
        hot = self.at_points @ old
        data = constant.copy()
        cubed = RADIATING * hot**3 * self.weight
        data[self.surface_slot] += self.to_entries @ (4 * cubed)
        return data, self.to_nodes @ (3 * cubed * hot)

    def _solve(self, data: np.ndarray, right: np.ndarray, guess: np.ndarray) -> np.ndarray:
        matrix, inverse = self._matrix(data), 1 / data[self.diagonal]
        goal = self.rtol * np.linalg.norm(right)
        x = guess.copy()
        r = right - matrix @ x
        z = inverse * r
        p, rz = z.copy(), r @ z
        while np.linalg.norm(r) > goal:
            q = matrix @ p
            alpha = rz / (p @ q)
            x += alpha * p
            r -= alpha * q
            z = inverse * r
            new = r @ z
            p *= new / rz
            p += z
            rz = new
        return x

    def forward(self, conductivity: np.ndarray, history: list | None = None) -> np.ndarray:
        """Surface temperatures [K] after each step, (steps, surface nodes)."""
        constant = self._constant(conductivity)
        old = before = np.full(self.count, self.problem.start)
        surface = np.empty((self.problem.steps, len(self.nodes)))
        for step in range(self.problem.steps):
            data, extra = self._step(constant, old)
            if history is not None:
                history.append(old)
            right = self.mass_matrix @ old + self.load + extra
            if self.lamp is not None and (step + 0.5) * SIZE < self.problem.lamp.until:
                right += self.lamp
            new = self._solve(data, right, 2 * old - before)
            before, old = old, new
            surface[step] = old[self.nodes]
        if history is not None:
            history.append(old)
        return surface

    def gradient(self, conductivity: np.ndarray, target: np.ndarray) -> np.ndarray:
        """Derivative [K2 per W/m/K] of the mean squared misfit by each cell's conductivity."""
        history: list[np.ndarray] = []
        misfit = self.forward(conductivity, history) - target
        constant = self._constant(conductivity)
        along = np.zeros(len(self.upper))
        given, adjoint, later = (np.zeros(self.count) for _ in range(3))
        for step in range(self.problem.steps - 1, -1, -1):
            old, new = history[step], history[step + 1]
            given[self.nodes] += 2 / misfit.size * misfit[step]
            data, _ = self._step(constant, old)
            later, adjoint = adjoint, self._solve(data, given, 2 * adjoint - later)
            along += (adjoint[self.first] - adjoint[self.second]) * (
                new[self.first] - new[self.second]
            )
            hot, after = self.at_points @ old, self.at_points @ new
            turned = 12 * RADIATING * hot**2 * (hot - after) * self.weight
            given = self.mass_matrix @ adjoint + self.to_nodes @ (
                turned * (self.at_points @ adjoint)
            )
        entries = np.zeros(len(self.key))
        entries[self.upper] = along
        a, b = np.triu_indices(self.stiffness.shape[1], 1)
        width = self.stiffness.shape[1]
        slot = self.slot.reshape(-1, width, width)
        # One of the two entries of a pair lies above the diagonal.
        both = entries[slot[:, a, b]] + entries[slot[:, b, a]]
        return (self.stiffness[:, a, b] * both).sum(1)

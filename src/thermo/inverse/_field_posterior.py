"""Fields as the data leave them: deviations, shares of the prior, resolution, draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_matrix

from thermo.fields import DepartingField
from thermo.inverse._estimate import RecoveredField
from thermo.inverse._field_loss import FieldLoss
from thermo.inverse._properties import Stated
from thermo.mesh import Mesh, face_areas


@final
@dataclass(frozen=True)
class Smoothness:
    """The fields under one choice of steps between neighbours, all as logarithms [1].

    - `steps`: by field; `weight`: how probable the data make them.
    - `move`: from the estimate to the most probable values at the controls, (unknowns,), those of
      all fields in their order.
    - `covariance`: of these after the data, and `prior` before them, (unknowns, unknowns).
    """

    steps: dict[str, float]
    weight: float
    move: Float[np.ndarray, " unknowns"]
    covariance: Float[np.ndarray, "unknowns unknowns"]
    prior: Float[np.ndarray, "unknowns unknowns"]


@final
@dataclass(frozen=True)
class FieldPosterior:
    """What data and prior say of log(phi) at the controls of fields, near an estimate.

    A sum of normal distributions, one for each smoothness that the data allow, and on top of it
    what the errors of cells and steps, and of the surface's scale, may move.

    - `mesh`: linear mesh [m], `order` of its cells in the fit [1]; `stated`: the rest of the body's
      properties [SI].
    - `fields`: the estimate, by quantity; `points`: of their controls,
      by quantity, (controls, 3) [m].
    - `mixture`: the distributions, over the controls of all fields in their order.
    - `shift`: by how much the rest of what cells and steps make wrong moves log(phi), for each
      run, and last one deviation of the surface's scale, where it is not exact,
      (unknowns, causes) [1].
    - `loss`: what the fit makes small, not linearised; None where that is not at hand.

    Source: D. J. C. MacKay, Neural Computation 4 (1992) 415; the mean over hyperparameters,
    Kaipio and Somersalo, Statistical and Computational Inverse Problems (2005), section 3.
    """

    mesh: Mesh
    order: int
    stated: Stated
    fields: Mapping[str, DepartingField]
    points: dict[str, Float[np.ndarray, "controls 3"]]
    mixture: list[Smoothness]
    shift: Float[np.ndarray, "unknowns causes"]
    loss: FieldLoss | None = None

    def part(self, name: str) -> slice:
        """Where the controls of a quantity are among those of all [1]."""
        names = list(self.fields)
        counts = [len(self.points[other]) for other in names]
        begin = sum(counts[: names.index(name)])
        return slice(begin, begin + counts[names.index(name)])

    @cached_property
    def covariance(self) -> Float[np.ndarray, "unknowns unknowns"]:
        """Covariance of log(phi) at the controls about the estimate [1]."""
        spread = sum(
            one.weight * (one.covariance + np.outer(one.move, one.move)) for one in self.mixture
        )
        return np.asarray(spread) + self.shift @ self.shift.T

    @cached_property
    def prior(self) -> Float[np.ndarray, "unknowns unknowns"]:
        """Covariance of log(phi) before the data, as smooth as these ask for [1]."""
        return np.asarray(sum(one.weight * one.prior for one in self.mixture))

    def onto_faces(self, name: str) -> Float[np.ndarray, "faces controls"]:
        """Weights [1] that carry log(phi) from the controls to the faces."""
        extension = self.fields[name].extension
        index, weight = np.asarray(extension.face_index), np.asarray(extension.face_weight)
        rows = np.repeat(np.arange(len(index)), index.shape[1])
        shape = (len(index), len(self.points[name]))
        return csr_matrix((weight.ravel(), (rows, index.ravel())), shape=shape).toarray()

    def deviation(self, name: str) -> Float[np.ndarray, " faces"]:
        """Standard deviation of log(phi) on the faces about the estimate [1]."""
        return _deviation(self.onto_faces(name), self._of(self.covariance, name))

    def informed(self, name: str) -> Float[np.ndarray, " faces"]:
        """Share of the prior's variance that the data take away, of what each face differs by [1].

        Of log(phi) on a face less its mean over the surface: before the data that mean is open
        over all that is physical, and beside it any place would look well known.
        """
        onto = self.onto_faces(name)
        apart = onto - self.shares() @ onto
        after, before = (
            _deviation(apart, self._of(matrix, name)) for matrix in (self.covariance, self.prior)
        )
        return np.clip(1 - (after / np.maximum(before, 1e-12)) ** 2, 0.0, 1.0)

    def mean(self, name: str) -> tuple[float, float, float]:
        """Mean of log(phi) over the surface, its deviation, and that before the data [1]."""
        along = self.shares() @ self.onto_faces(name)
        middle = float(self.shares() @ np.log(np.asarray(self.fields[name].face_values())))
        after, before = (
            float(_deviation(along[None], self._of(matrix, name))[0])
            for matrix in (self.covariance, self.prior)
        )
        return middle, after, before

    def resolution(self, name: str) -> Float[np.ndarray, " controls"]:
        """Length over which the estimate at a control means over the truth [m].

        The root mean square distance of the truth that a row of R = I - C Q^-1 holds, R being the
        derivative of the estimate by the truth: between controls, and within the piece of surface
        that each control stands for, taken as a disc. Where a row is all but empty the estimate is
        the prior's, and `informed` says so.

        Source: Backus and Gilbert, Geophys. J. R. astr. Soc. 16 (1968) 169, the spread.
        """
        mine, place = self.part(name), self.points[name]
        square = np.zeros((len(place), len(place)))
        for one in self.mixture:
            # The whole R first: what others take up of this field is no part of it.
            rows = np.eye(len(one.prior)) - np.linalg.solve(one.prior, one.covariance).T
            square += one.weight * rows[mine, mine] ** 2
        apart = np.linalg.norm(place[:, None] - place[None], axis=-1)
        between = (square * apart**2).sum(1) / np.maximum(square.sum(1), 1e-30)
        within = face_areas(self.mesh).sum() / (2 * np.pi * len(place))
        return np.sqrt(between + within)

    def eigenvalues(self) -> Float[np.ndarray, " directions"]:
        """Of the data's information in units of the prior's, the largest first [1].

        Above 1 the data lead, below 1 the prior, under the smoothness that is most probable.
        """
        likely = max(self.mixture, key=lambda one: one.weight)
        root = np.linalg.cholesky(likely.prior)
        ratio = np.linalg.solve(root, np.linalg.solve(root, likely.covariance).T)
        left = np.clip(np.linalg.eigvalsh((ratio + ratio.T) / 2), 1e-300, 1.0)
        return 1 / left - 1

    def draw(self, count: int, *, seed: int = 0) -> list[dict[str, RecoveredField]]:
        """`count` [1] sets of fields that data and prior allow."""
        random = np.random.default_rng(seed)
        weights = np.array([one.weight for one in self.mixture])
        picked = random.choice(len(weights), count, p=weights / weights.sum())
        roots = {number: _root(self.mixture[number].covariance) for number in set(picked)}
        made = []
        for number in picked:
            one = self.mixture[number]
            moved = one.move + roots[number] @ random.standard_normal(len(one.move))
            moved += self.shift @ random.standard_normal(self.shift.shape[1])
            made.append(self._departed(moved))
        return made

    def _departed(self, moved: Float[np.ndarray, " unknowns"]) -> dict[str, RecoveredField]:
        found = {}
        for name, field in self.fields.items():
            there, bounds = (
                field.with_parameters(jnp.asarray(moved[self.part(name)])),
                field.quantity,
            )
            cells, faces = (
                np.clip(np.asarray(values), bounds.lower, bounds.upper)
                for values in (there.cell_values(), there.face_values())
            )
            found[name] = RecoveredField(name, bounds.unit, cells, faces)
        return found

    def shares(self) -> Float[np.ndarray, " faces"]:
        """Each face's part of the surface [1]."""
        areas = face_areas(self.mesh)
        return areas / areas.sum()

    def _of(self, matrix: Float[np.ndarray, "unknowns unknowns"], name: str) -> np.ndarray:
        return matrix[self.part(name), self.part(name)]


def _deviation(
    rows: Float[np.ndarray, "rows controls"], covariance: Float[np.ndarray, "controls controls"]
) -> Float[np.ndarray, " rows"]:
    return np.sqrt(np.maximum(np.einsum("ri,ij,rj->r", rows, covariance, rows), 0.0))


def _root(covariance: Float[np.ndarray, "unknowns unknowns"]) -> np.ndarray:
    """A root of a covariance that may be all but singular."""
    size, way = np.linalg.eigh(covariance)
    return way * np.sqrt(np.maximum(size, 0.0))

"""How smooth the fields are, by the evidence of the data themselves."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np
from jaxtyping import Float

# Standard deviations of log(phi) between neighbours that are tried [1]: at the least a field of
# some hundred controls varies by less than a percent, at the most neighbours differ twentyfold.
LEAST_STEP: Final = 1e-3
MOST_STEP: Final = 3.0
_TRIED: Final = np.geomspace(LEAST_STEP, MOST_STEP, 33)
# Twice the logarithm of the evidence for a field that varies over that for one value, from which it
# is very strong [1] (Kass and Raftery). The best step was sought, and errors are known roughly
# only, so less is no ground to call a body uneven.
_VERY_STRONG: Final = 10.0
# So many combinations of steps of several fields are looked at, at the most, and those that are
# less likely than the likeliest by this factor are left out [1].
_COMBINATIONS: Final = 1000
_UNLIKELY: Final = 1e-4
# With several fields one step is chosen after the other, so often [1].
_ROUNDS: Final = 3
# Curvature of directions that nothing is known of, absolute and as a share of the data's largest
# [1]: they stay where they are, and count alike under all steps.
_FAINT, _FAINT_SHARE = 1e-6, 1e-10


@final
@dataclass(frozen=True)
class Linearised:
    """A fit near a point, all whitened [1].

    - `information`: of the data and of the priors other than smoothness, (unknowns, unknowns).
    - `slope`: of half their sum of squares, (unknowns,).
    - `rough`: by field, derivative of the differences between neighbours, (pairs, unknowns), and
      `apart`, these differences, (pairs,).
    """

    information: Float[np.ndarray, "unknowns unknowns"]
    slope: Float[np.ndarray, " unknowns"]
    rough: dict[str, Float[np.ndarray, "pairs unknowns"]]
    apart: dict[str, Float[np.ndarray, " pairs"]]

    @cached_property
    def _quadratics(self) -> dict[str, tuple[np.ndarray, np.ndarray, float, int]]:
        """By field D'D, D'a, |a|^2 and the rank of D, the same for all steps."""
        return {
            name: (rows.T @ rows, rows.T @ self.apart[name], float(np.sum(self.apart[name] ** 2)),
                   int(np.linalg.matrix_rank(rows)))
            for name, rows in self.rough.items()
        }  # fmt: skip

    def solve(
        self, steps: dict[str, float]
    ) -> tuple[Float[np.ndarray, " unknowns"], Float[np.ndarray, "unknowns unknowns"]]:
        """The move to the most probable point and the curvature there [1].

        `steps`: standard deviation between neighbours, by field [1].
        """
        curvature, slope = self._total(steps)
        return -np.linalg.solve(curvature, slope), curvature

    def _total(self, steps: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        faint = max(_FAINT, _FAINT_SHARE * float(np.diagonal(self.information).max()))
        curvature, slope = self.information + faint * np.eye(len(self.slope)), self.slope.copy()
        for name, step in steps.items():
            square, pull, _, _ = self._quadratics[name]
            curvature += square / step**2
            slope += pull / step**2
        return curvature, slope

    def log_evidence(self, steps: dict[str, float]) -> float:
        """Logarithm of the density of the data given the steps, but for a constant [1].

        ln p = -min_d [F(d) + sum |D d + a|^2 / (2 s^2)] - sum rank(D) ln s - 1/2 ln det H

        with F half the sum of squares of data and other priors, D d + a the differences between
        neighbours after a move d, H the curvature of all, and sums over fields.
        """
        curvature, slope = self._total(steps)
        loss = -0.5 * slope @ np.linalg.solve(curvature, slope)
        for name, step in steps.items():
            _, _, apart, rank = self._quadratics[name]
            loss += 0.5 * apart / step**2 + rank * np.log(step)
        return -float(loss) - 0.5 * float(np.linalg.slogdet(curvature)[1])


def most_probable_steps(near: Linearised) -> dict[str, float]:
    """Standard deviation [1] of the difference between neighbours of each field.

    The ones under which the data are the most probable, the field integrated out. Too much freedom
    is punished by the volume of fields that fit no better, so no truth and no tuning is needed.
    A field for whose variation the evidence is not very strong gets the least step: one value.

    Source: D. J. C. MacKay, Neural Computation 4 (1992) 415, sections 3 and 4; R. E. Kass and
    A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773, section 3.2.
    """
    steps = dict.fromkeys(near.rough, float(np.sqrt(LEAST_STEP * MOST_STEP)))
    for _ in range(_ROUNDS if len(steps) > 1 else 1):
        for name in steps:
            likely = [near.log_evidence({**steps, name: float(step)}) for step in _TRIED]
            best = int(np.argmax(likely))
            strong = 2 * (likely[best] - likely[0]) > _VERY_STRONG
            steps[name] = float(_TRIED[best]) if strong else LEAST_STEP
    return steps


def likely_steps(near: Linearised) -> list[tuple[dict[str, float], float]]:
    """Steps of all fields that the data allow, and how probable they make each [1].

    Before the data all steps between the least and the most are alike on a logarithmic scale. A
    field without neighbours has any step.

    Source: MacKay (1992), section 3: the evidence as the probability of a hyperparameter.
    """
    varied = [name for name, rows in near.rough.items() if np.any(rows)]
    count = min(len(_TRIED), int(_COMBINATIONS ** (1 / max(len(varied), 1))))
    tried = np.geomspace(LEAST_STEP, MOST_STEP, count)
    steps = [
        {**dict.fromkeys(near.rough, 1.0), **dict(zip(varied, map(float, values), strict=True))}
        for values in itertools.product(tried, repeat=len(varied))
    ]
    logs = np.array([near.log_evidence(one) for one in steps])
    weights = np.exp(logs - logs.max())
    kept = weights > _UNLIKELY
    weights = np.where(kept, weights, 0.0) / weights[kept].sum()
    return [(one, float(weight)) for one, weight in zip(steps, weights, strict=True) if weight > 0]

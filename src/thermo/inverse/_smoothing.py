"""The smoothness of the fields and the weight of the data, chosen where a fit stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._effective_size import repeats
from thermo.inverse._evidence import Linearised, most_probable_steps
from thermo.inverse._objective import (
    Objective,
    belief_residual,
    jacobian,
    neighbour_differences,
    residual,
    run_parts,
    start,
    with_fields,
)

WEAK_STEP: Final = 0.3
"""Standard deviation of log(phi) between neighbours [1] before the data have been asked."""

ALL_BUT_UNIFORM: Final = 0.01
"""Standard deviation between neighbours [1] up to which a field may be called uniform."""

# Steps and weights that change by less than these factors are as good as before [1].
_SAME_STEP, _SAME_WEIGHT = 2.0, 1.5


@final
@dataclass(frozen=True)
class Choice:
    """What the data ask for.

    - `steps`: by field, standard deviation of log(phi) between neighbours [1].
    - `weights`: of each run, a factor on those of its readings, at most 1, (runs,) [1].
    """

    steps: dict[str, float]
    weights: Float[np.ndarray, " runs"]


@final
@dataclass(frozen=True)
class Nearby:
    """A fit near where it stands.

    - `fit`: with what its readings are worth; `weights`: as of `Choice` [1].
    - `slopes`: of the whitened residual, times what each reading is worth, (values, unknowns) [1].
    - `beliefs`: information of the priors other than smoothness, (unknowns, unknowns) [1].
    """

    fit: Linearised
    weights: Float[np.ndarray, " runs"]
    slopes: Float[np.ndarray, "values unknowns"]
    beliefs: Float[np.ndarray, "unknowns unknowns"]


def ask_data(objective: Objective, samples: Sequence[np.ndarray]) -> Choice:
    """The smoothness and the weights [1] that the data ask for where a fit stands.

    First the field is let loose: what a linearised fit with little smoothness leaves is no field's
    doing, but noise and the errors of the simulation. Where that rest is larger than the noise
    that was stated, or its values repeat their neighbours, the weight of the run falls until it
    counts as the independent readings that it holds; it never rises. Then the steps between
    neighbours are those of greatest evidence.

    Arguments:

    - `objective`: its fields stand where the fit does; its weights are the first ones. Slopes
      are those of its `tangents`, where it has them.
    - `samples`: where the samples of each run are, (samples, 3) [m].
    """
    near = linearised(objective, samples)
    return Choice(most_probable_steps(near.fit), near.weights)


def linearised(objective: Objective, samples: Sequence[np.ndarray]) -> Nearby:
    """A fit near where it stands, each of its runs worth the independent readings it holds [1].

    Arguments as for `ask_data`, which says how the weights of the runs are found.
    """
    data, slopes = _linearise(objective)
    beliefs, rough, apart = _priors(objective)

    def near(share: Float[np.ndarray, " values"]) -> Linearised:
        information = slopes.T @ (slopes * share[:, None]) + beliefs[1].T @ beliefs[1]
        slope = slopes.T @ (share * data) + beliefs[1].T @ beliefs[0]
        return Linearised(information, slope, rough, apart)

    move, _ = near(np.ones_like(data)).solve(dict.fromkeys(rough, WEAK_STEP))
    rest = data + slopes @ move
    share, weights = np.ones_like(data), np.ones(len(samples))
    for run, part, weight in run_parts(objective):
        places, known = samples[run], weight > 0
        error = rest[part].reshape(known.shape)[:, : len(places)]
        square = float(np.mean(rest[part][known.ravel()] ** 2))
        inflation = max(1.0, square * repeats(error, known[:, : len(places)], places))
        share[part], weights[run] = 1 / inflation, 1 / np.sqrt(inflation)
    own = beliefs[1].T @ beliefs[1]
    return Nearby(near(share), weights, slopes * share[:, None], own)


def much_the_same(one: Objective, other: Objective) -> bool:
    """Whether two choices of smoothness and weights [1] would give the same fields."""
    for name, prior in one.priors.items():
        both = np.maximum([prior.step, other.priors[name].step], ALL_BUT_UNIFORM)
        if both.max() > _SAME_STEP * both.min():
            return False
    for mine, theirs in zip(one.cases, other.cases, strict=True):
        heavy, light = np.asarray(mine.trust), np.asarray(theirs.trust)
        if np.any(np.maximum(heavy, light) > _SAME_WEIGHT * np.minimum(heavy, light)):
            return False
    return True


@program
def _evaluate(objective: Objective) -> tuple[Float[Array, " all"], Float[Array, "all unknowns"]]:
    here = start(objective)
    if objective.tangents is None:
        return jacobian(objective, here)
    return residual(objective, here), jacobian(objective.tangents, here)[1]


def _linearise(
    objective: Objective,
) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values unknowns"]]:
    """The whitened residual of all runs and its slopes [1]."""
    value, matrix = _evaluate(objective)
    count = sum(case.data.size for case in objective.cases)
    return np.asarray(value)[:count], np.asarray(matrix)[:count]


def _priors(
    objective: Objective,
) -> tuple[tuple[np.ndarray, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Beliefs with their slopes; slopes of the differences between neighbours; these."""
    flat, unravel = ravel_pytree(start(objective))

    def beliefs(point: Float[Array, " unknowns"]) -> Float[Array, " terms"]:
        fields = with_fields(objective, unravel(point))
        terms = [belief_residual(objective.priors[name], fields[name]) for name in fields]
        return jnp.concatenate(terms)

    def apart(point: Float[Array, " unknowns"]) -> dict[str, Float[Array, " pairs"]]:
        fields = with_fields(objective, unravel(point))
        return {
            name: neighbour_differences(objective.priors[name], fields[name]) for name in fields
        }

    slopes = jax.jacfwd(beliefs)(flat)
    rough = {name: np.asarray(rows) for name, rows in jax.jacfwd(apart)(flat).items()}
    differences = {name: np.asarray(values) for name, values in apart(flat).items()}
    return (np.asarray(beliefs(flat)), np.asarray(slopes)), rough, differences


def with_choice(objective: Objective, choice: Choice) -> Objective:
    """The objective, and its tangents, with the steps and the weights [1] of a choice."""
    priors = {
        name: replace(prior, step=jnp.asarray(choice.steps[name]))
        for name, prior in objective.priors.items()
    }
    cases, numbers = [], list(objective.sequence)
    for case in objective.cases:
        mine, numbers = numbers[: len(case.trust)], numbers[len(case.trust) :]
        cases.append(replace(case, trust=case.trust * jnp.asarray(choice.weights[mine])))
    tangents = objective.tangents
    if tangents is not None:
        tangents = with_choice(tangents, choice)
    return replace(objective, priors=priors, cases=tuple(cases), tangents=tangents)

"""Unknowns as the data leave them, drawn from the posterior and not from its linearisation."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.errors import InputError
from thermo.identify._bounds import Bounds, checked_bounds
from thermo.identify._path import Model, Point, settle
from thermo.inverse import NORMAL

_LENGTH: Final = 1.65
"""Deviation of a proposal in one dimension [1], of a normal distribution's own."""

_TAILS: Final = (0.025, 0.975)

Density = Callable[[Float[np.ndarray, " unknowns"]], tuple[Array, Array]]
"""Logarithm of a density and its slope [1] at deviations from the optimum [1]."""


@final
@dataclass(frozen=True)
class Samples:
    """Draws of the unknowns.

    - `unknowns`: one after the other, (draws, unknowns) [1].
    - `accepted`: share of the proposals that were taken [1].
    - `effective`: independent draws that know the mean of each unknown as well, (unknowns,) [1].
    - `linear`: half-width of the 95 % interval by the slopes at the optimum, (unknowns,) [1].
    """

    unknowns: Float[np.ndarray, "draws unknowns"]
    accepted: float
    effective: Float[np.ndarray, " unknowns"]
    linear: Float[np.ndarray, " unknowns"]

    def intervals(self) -> Float[np.ndarray, "unknowns 2"]:
        """In which 95 % of the draws of each unknown lie [1]."""
        return np.quantile(self.unknowns, _TAILS, axis=0).T


def samples(
    model: Model,
    start: Float[np.ndarray, " unknowns"],
    *,
    bounds: Bounds,
    count: int = 400,
    seed: int = 0,
    on_draw: Callable[[int], object] = lambda _: None,
) -> Samples:
    """Draws of exp(-|r(u)|^2 / 2) within bounds, by Langevin steps that are taken or left (MALA).

    For few unknowns, where a profile says that the linear interval is not to be trusted. Unknowns
    are measured in deviations of the linearised posterior, so that a step of one length suits all;
    a draw takes one residual and Jacobian, and some are alike: `effective` says how many count. The
    first quarter of the steps, before the count, is left out.

    Arguments:

    - `model`: whitened residual, priors included, and its Jacobian, at unknowns [1], as `log_model`
      gives it.
    - `start`: near the optimum, which is sought first (unknowns,) [1].
    - `bounds`: of the unknowns, within which they are alike before the data, (unknowns, 2) [1].
    - `count`: draws [1], with a `seed`; `on_draw`: told how many steps are done.

    Raises `InputError` for fewer than 10 draws, for bounds that are not finite, not those of the
    unknowns or that leave no room, and where blackjax is not installed (extra `sampling`).

    Source: Roberts and Tweedie, Bernoulli 2 (1996) 341; the length of a step, Roberts and
    Rosenthal, J. R. Statist. Soc. B 60 (1998) 255.
    """
    start = np.asarray(start, float)
    limits = checked_bounds(bounds, len(start))
    _refuse(limits, count)
    from blackjax.diagnostics import effective_sample_size  # noqa: PLC0415 - an extra

    at = settle(model, start, limits)
    root = _root(at, limits)
    drawn, taken, early = [], [], -(-count // 4)
    for state, accepted in _chain(_density(model, at, root, limits), len(start), seed):
        drawn.append(state)
        taken.append(accepted)
        on_draw(len(drawn))
        if len(drawn) >= early + count:
            break
    if not any(taken[early:]):
        raise InputError(
            "no step of the draws could be taken", where="bounds", value=limits.tolist(),
            limit="bounds that hold more than the optimum, which lies at "
            + ", ".join(f"{one:.4g}" for one in at.unknowns),
            remedy="give wider ones; they are of logarithms where `model` is a `LogModel`",
        )  # fmt: skip
    kept = np.array(drawn[early:])
    # Operation by operation it is a hundred small programs, which take longer than the draws.
    effective = np.atleast_1d(jax.jit(effective_sample_size)(jnp.asarray(kept)[None]))
    return Samples(
        at.unknowns + kept @ root.T,
        float(np.mean(taken[early:])),
        np.minimum(effective, count),
        NORMAL * np.linalg.norm(root, axis=1),
    )


def _chain(
    density: Density, unknowns: int, seed: int
) -> Iterator[tuple[Float[np.ndarray, " unknowns"], bool]]:
    """Deviations [1] step by step, and whether each was accepted.

    The density is asked between two programs: it may run programs of its own, and those of the
    step would be compiled anew each time if it were part of them.
    """
    from blackjax.mcmc import mala  # noqa: PLC0415 - an extra

    propose, decide = _steps(unknowns)
    key, begun = jax.random.key(seed), jnp.zeros(unknowns)
    state = mala.init(begun, _known(*density(np.asarray(begun))))
    for number in itertools.count():
        mine = jax.random.fold_in(key, number)
        proposed = density(np.asarray(propose(mine, state)))
        state, told = decide(mine, state, *proposed)
        yield np.asarray(state.position), bool(told.is_accepted)


@functools.cache
def _steps(unknowns: int) -> tuple[Callable[..., Array], Callable[..., Any]]:
    """What proposes a step and what decides on it: compiled once for a number of unknowns [1]."""
    from blackjax.mcmc import diffusions, mala  # noqa: PLC0415 - an extra

    size, kernel = 0.5 * _LENGTH**2 * unknowns ** (-1 / 3), mala.build_kernel()

    @jax.jit
    def propose(key: Array, state: Any) -> Array:
        # As the kernel does: the first of two keys moves, and the slope there is not asked yet.
        move = diffusions.overdamped_langevin(lambda at: (jnp.zeros(()), jnp.zeros_like(at)))
        return jnp.asarray(move(jax.random.split(key)[0], state, size).position)

    @jax.jit
    def decide(key: Array, state: Any, value: Array, slope: Array) -> Any:
        return kernel(key, state, _known(value, slope), size)

    return propose, decide


def _known(value: Array, slope: Array) -> Callable[[Array], Array]:
    """A density [1] and its slope [1] that are known at the one point where they are asked for."""

    @jax.custom_vjp
    def density(at: Array) -> Array:
        del at
        return value

    def backward(_: None, given: Array) -> tuple[Array]:
        return (given * slope,)

    density.defvjp(lambda at: (density(at), None), backward)
    return density


def _refuse(bounds: Float[np.ndarray, "unknowns 2"], count: int) -> None:
    if count < 10:
        raise InputError(
            "so few draws say nothing", where="count", value=count, limit="10 or more",
            remedy="leave it at 400",
        )  # fmt: skip
    if not np.all(np.isfinite(bounds)):
        raise InputError(
            "draws need bounds on both sides", where="bounds", value=bounds.tolist(),
            limit="finite numbers", remedy="give `LogModel.bounds`",
        )  # fmt: skip
    if find_spec("blackjax") is None:
        raise InputError(
            "draws are made by a package that is not here", where="samples", value="blackjax",
            limit="the extra `sampling`", remedy="pip install 'thermofield[sampling]'",
        )  # fmt: skip


def _root(
    at: Point, bounds: Float[np.ndarray, "unknowns 2"]
) -> Float[np.ndarray, "unknowns unknowns"]:
    """A root of the linearised covariance [1]; the bounds are a spread where nothing else is."""
    low, high = bounds.T
    information = at.jacobian.T @ at.jacobian + np.diag(12 / (high - low) ** 2)
    return np.linalg.cholesky(np.linalg.inv(information))


def _density(
    model: Model,
    at: Point,
    root: Float[np.ndarray, "unknowns unknowns"],
    bounds: Float[np.ndarray, "unknowns 2"],
) -> Density:
    """Logarithm of the density and its slope [1] at deviations from the optimum [1]."""
    low, high = bounds.T

    def density(deviations: Float[np.ndarray, " unknowns"]) -> tuple[Array, Array]:
        there = at.unknowns + root @ deviations
        if np.any((there < low) | (there > high)):
            return jnp.asarray(-jnp.inf), jnp.zeros(len(root))
        residual, jacobian = model(there)
        half = 0.5 * (residual @ residual - at.chi2)
        return jnp.asarray(-half), jnp.asarray(-root.T @ (jacobian.T @ residual))

    return density

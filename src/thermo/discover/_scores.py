"""The score of every candidate at zero strength, and what chance alone would reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float
from scipy.stats import chi2, norm

from thermo.discover._entries import Entry
from thermo.discover._projection import Projection

# A strength that would be large has to be seen at this many deviations, or the data say nothing.
_SEEN: Final = 1.0
_DRAWS: Final = 4000


@final
@dataclass(frozen=True)
class Score:
    """What the data say of one part of a candidate, linearised where it is absent.

    - `entry`; `z`: score in standard deviations, a normal equivalent where strengths are joint [1].
    - `strength`: predicted, (strengths,) in the card's unit; `sd`: of the last of them.
    - `visible`: share of the signature that the unknowns do not swallow [1].
    - `correlation`: cosine of the largest of its signatures with what is left, unknowns or not [1].
    - `columns`: where it stands in `ScoreTable.alike`.
    """

    entry: Entry
    z: float
    strength: Float[np.ndarray, " strengths"]
    sd: float
    visible: float
    correlation: float
    columns: slice

    def name(self) -> str:
        """Of the kind."""
        return self.entry.card.name


@final
@dataclass(frozen=True)
class ScoreTable:
    """The scores of all parts that could be seen, and the threshold of the largest [1].

    - `alike`: correlation of the scores of all strengths, (columns, columns) [1].
    - `unit`: the signatures beside the unknowns, each of length one, (values, columns) [1].
    - `unfollowed`: scores that a round leaves aside, whatever they pass.
    """

    scores: list[Score]
    unseen: list[Entry]
    threshold: float
    alike: Float[np.ndarray, "columns columns"]
    unit: Float[np.ndarray, "values columns"]
    unfollowed: Sequence[Score] = ()

    def largest(self, draws: Float[np.ndarray, "draws columns"]) -> Float[np.ndarray, " draws"]:
        """The largest score of all of each draw of normal scores of all strengths [1]."""
        return _largest(draws, self.alike, self.scores)


def score_table(
    found: Sequence[Entry],
    signatures: Float[np.ndarray, "values columns"],
    residual: Float[np.ndarray, " values"],
    free: Projection,
    *,
    alpha: float,
    seed: int = 0,
) -> ScoreTable:
    """Lagrange-multiplier scores z = -g' P r / (g' P g)^1/2 of all candidates.

    Arguments:

    - `free`: P, what the unknowns leave of values [1].
    - `found`: parts, whose `signatures` stand column by column, each by its typical strength [1].
    - `residual`: simulation less readings, whitened, at an optimum of what is `free` [1].
    - `alpha`: chance of the largest score of all to pass the threshold where nothing is missing.

    Source: Rao, Proc. Camb. Phil. Soc. 44 (1948) 50; the maximum by drawing normal scores with
    their correlation.
    """
    left = free.left(signatures)
    product = signatures.T @ left
    pull = -(left.T @ residual)
    raw = np.sqrt((signatures**2).sum(0))
    size = np.sqrt(np.maximum(np.diag(product), 0.0))
    length = np.maximum(raw * np.linalg.norm(residual), 1e-300)
    alike_left = np.abs(signatures.T @ residual) / length
    scores, unseen, kept = [], [], []
    begin = 0
    for entry in found:
        part = np.arange(begin, begin + len(entry.strengths))
        begin += len(part)
        if size[part].max() < _SEEN:
            unseen.append(entry)
            continue
        inverse = np.linalg.pinv(product[np.ix_(part, part)], rcond=1e-6, hermitian=True)
        strength = inverse @ pull[part]
        told = float(pull[part] @ strength)
        z = float(np.sign(pull[part[-1]]) * _normal_equivalent(told, len(part)))
        scores.append(
            Score(
                entry,
                z,
                strength * entry.card.typical,
                float(np.sqrt(inverse[-1, -1])) * entry.card.typical,
                float(size[part].max() / max(raw[part].max(), 1e-300)),
                float(alike_left[part].max()),
                slice(len(kept), len(kept) + len(part)),
            )
        )
        kept.extend(part)
    # One strength of several may show nothing.
    length = np.where(size > 0, size, 1.0)[kept]
    alike = product[np.ix_(kept, kept)] / np.outer(length, length)
    threshold = _threshold(alike, scores, alpha, seed)
    return ScoreTable(scores, unseen, threshold, alike, left[:, kept] / length)


def best_of_kinds(scores: Sequence[Score]) -> list[Score]:
    """Of each kind the part of the largest score, the largest of all first."""
    best: dict[str, Score] = {}
    for score in sorted(scores, key=lambda one: -abs(one.z)):
        best.setdefault(score.name(), score)
    return list(best.values())


def credible(score: Score, threshold: float) -> bool:
    """Whether a score passes the threshold [1] to a side on which its strength can be."""
    low = score.entry.card.low
    return abs(score.z) > threshold and (low < 0 or score.z > 0)


def _normal_equivalent(told: float, count: int) -> float:
    """The normal deviate [1] as unlikely as a chi-square of so many degrees of freedom."""
    if count == 1:
        return float(np.sqrt(told))
    chance = chi2.sf(told, count)
    return float(norm.isf(chance / 2)) if chance > 1e-200 else float(np.sqrt(told - count))


def _threshold(
    alike: Float[np.ndarray, "columns columns"],
    scores: Sequence[Score],
    alpha: float,
    seed: int,
) -> float:
    """What the largest score passes with chance `alpha` [1] where nothing is missing."""
    if not scores:
        return float(norm.isf(alpha / 2))
    draws = normal_draws(alike, seed)
    return float(np.quantile(_largest(draws, alike, scores), 1 - alpha))


def normal_draws(
    covariance: Float[np.ndarray, "columns columns"], seed: int
) -> Float[np.ndarray, "draws columns"]:
    """Normal values of mean zero with a covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return np.random.default_rng(seed).standard_normal((_DRAWS, len(covariance))) @ root.T


def _largest(
    draws: Float[np.ndarray, "draws columns"],
    alike: Float[np.ndarray, "columns columns"],
    scores: Sequence[Score],
) -> Float[np.ndarray, " draws"]:
    largest = np.zeros(len(draws))
    for score in scores:
        some = draws[:, score.columns]
        if some.shape[1] == 1:
            one_sided = score.entry.card.low >= 0
            each = some[:, 0] if one_sided else np.abs(some[:, 0])
        else:
            own = alike[score.columns, score.columns]
            inverse = np.linalg.pinv(own, rcond=1e-6, hermitian=True)
            told = np.einsum("di,ij,dj->d", some, inverse, some)
            each = norm.isf(np.maximum(chi2.sf(told, some.shape[1]), 1e-200) / 2)
        largest = np.maximum(largest, each)
    return largest

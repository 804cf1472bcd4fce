"""Temperatures of scattered samples, brought to the vertices of a surface."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError

NEAREST: Final = 5
"""Samples that a vertex takes its temperature from [1]; the paper states none.

`benchmarks/nearest_samples.py` leaves each of 600 samples of six objects out in turn and guesses it
from k others, for 28 fields. Over the root mean square error of each field's own best k, 5 is worse
by 3 % in the geometric mean and by 13 % at the most; 4 by 6 % and 27 %, 6 by 4 % and 20 %.
"""


@final
class SampleWeights(eqx.Module):
    """What each sample adds to each vertex; all leaves are NumPy arrays.

    Arguments:

    - `nearest`: numbers of the samples next to each vertex, (vertices, k).
    - `weights`: theirs, (vertices, k) [1]: at least 0, of sum 1.
    - `samples`: how many there are.
    """

    nearest: Int[np.ndarray, "vertices k"]
    weights: Float[np.ndarray, "vertices k"]
    samples: int = eqx.field(static=True)


def sample_weights(
    samples: Float[np.ndarray, "samples 3"],
    vertices: Float[np.ndarray, "vertices 3"],
    *,
    k: int = NEAREST,
) -> SampleWeights:
    """Weights of the k samples nearest to each vertex, by inverse distance.

    w_mj = d_mj^-1 / sum_l d_ml^-1 with d_mj = |v_m - x_j|. A vertex on which samples lie takes
    their value alone.

    Arguments: `samples` and `vertices`, positions [m].

    Raises `InputError` where `k` is no whole number from 1 to the number of samples, and for
    positions that are not finite.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F8).
    """
    for name, places in (("samples", samples), ("vertices", vertices)):
        bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
        if bad.size:
            raise InputError(
                "a position is not finite", where=name,
                value=f"number {bad[0]}: {places[bad[0]].tolist()}", limit="finite metres",
                remedy="drop the samples whose position is unknown",
            )  # fmt: skip
    whole = isinstance(k, int | np.integer) and not isinstance(k, bool)
    if not whole or not 1 <= k <= len(samples):
        raise InputError(
            "there are no so many samples", where="k", value=k,
            limit=f"a whole number from 1 to {len(samples)}, the number of samples",
            remedy="give a smaller `k`, or more samples",
        )  # fmt: skip
    distance, nearest = map(np.asarray, KDTree(samples).query(vertices, k=int(k)))
    distance, nearest = distance.reshape(-1, k), nearest.reshape(-1, k)
    least = distance[:, :1]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Over the least distance, so that nothing grows beyond bounds beside a sample.
        closeness = np.where(least > 0, least / distance, distance == 0)
    weights = closeness / closeness.sum(axis=1, keepdims=True)
    return SampleWeights(nearest.astype(np.int64), weights, len(samples))


def interpolated(
    weights: SampleWeights, values: Float[np.ndarray, "frames samples"]
) -> Float[np.ndarray, "frames vertices"]:
    """Temperatures [K] of the vertices: T_m = sum_j w_mj T_j in each frame.

    Raises `InputError` where `values` is not of these samples, or not finite.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F8).
    """
    if values.shape[1] != weights.samples:
        raise InputError(
            "these values are of other samples", where="values",
            value=f"{values.shape[1]} samples", limit=f"{weights.samples} samples",
            remedy="give one column a sample, in the order of their positions",
        )  # fmt: skip
    if not np.isfinite(values).all():
        frame, sample = np.argwhere(~np.isfinite(values))[0]
        raise InputError(
            "a sample has no temperature", where="values", value=f"frame {frame}, sample {sample}",
            limit="finite kelvin",
            remedy="leave such samples out of the weights, or fill them, as `Recording` does",
        )  # fmt: skip
    count, k = weights.nearest.shape
    begins = np.arange(0, count * k + 1, k)
    table = sp.csr_array(
        (weights.weights.ravel(), weights.nearest.ravel(), begins), shape=(count, weights.samples)
    )
    return np.ascontiguousarray((table @ values.T).T)

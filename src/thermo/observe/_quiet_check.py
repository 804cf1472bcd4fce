"""Whether quiet frames are as the noise estimate takes them to be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float

from ._noise import LEAST_FRAMES, LEAST_SAMPLES, Noise, without_common
from ._recording import Recording

_FAR: Final = 5.0


@final
@dataclass(frozen=True)
class QuietCheck:
    """What quiet frames say of the noise model that was estimated from them.

    - `z`: by how many standard errors the mean square difference over three frames is not that of
      a first-order autoregressive fluctuation, which those over one and two frames foretell [1].
    - `far`: share of readings further than five standard deviations from their sample's mean [1].
    """

    z: float
    far: float

    def words(self) -> str:
        """A sentence for each thing that is not as it should be, or that all is."""
        found = []
        if abs(self.z) > 3:
            found.append(
                f"The fluctuation is not first-order autoregressive ({self.z:.1f} standard errors)."
            )
        if self.far > 1e-3:
            found.append(
                f"{100 * self.far:.2g} % of the readings lie far out: drop_spikes=true drops such."
            )
        return " ".join(found) or "The quiet frames are as the noise model has them."


def check_quiet(recording: Recording, noise: Noise) -> QuietCheck | None:
    """Test the noise model [K] on the quiet frames; None where they are too few.

    With d1, d2, d3 the mean square differences over one, two and three frames, such a fluctuation
    has d3 = d1 (1 + r + r^2), r = d2/d1 - 1. The standard error of the difference comes from
    leaving out one sample at a time, so samples are taken as independent.

    Source: the jackknife of Quenouille and Tukey; Efron and Stein, Ann. Statist. 9 (1981) 586.
    """
    quiet = recording.quiet
    if quiet is None:
        return None
    quiet = quiet[np.isfinite(quiet).any(1)][:, np.isfinite(quiet).any(0)]
    if len(quiet) < LEAST_FRAMES or quiet.shape[1] < LEAST_SAMPLES:
        return None
    # Samples of frames that are off as a whole are not independent.
    alone = without_common(quiet) if noise.frame > 0 else quiet
    sums = np.stack([squares(alone, lag) for lag in (1, 2, 3)])
    whole = sums.sum(-1)
    if np.any(whole[:, 1] == 0) or whole[0, 0] == 0:
        return None
    apart, error = first_order_misfit(whole), jackknife(sums)
    centred = alone - np.nanmean(alone, axis=0)
    known = np.isfinite(centred)
    far = np.abs(centred[known]) > _FAR * noise.white
    return QuietCheck(
        z=apart / error if error > 0 else 0.0,
        far=float(np.mean(far)),
    )


def squares(
    values: Float[np.ndarray, "frames samples"], lag: int, *, far: float = np.inf
) -> Float[np.ndarray, "2 samples"]:
    """Sum [K2] and number [1] of squared differences over a lag, by sample.

    Differences beyond `far` robust deviations [1] are left out.
    """
    difference = values[lag:] - values[:-lag]
    known = np.isfinite(difference)
    if np.isfinite(far) and known.any():
        usual = 1.4826 * np.median(np.abs(difference[known]))
        known &= np.abs(np.where(known, difference, 0.0)) <= far * usual
    return np.stack([np.sum(np.where(known, difference, 0.0) ** 2, 0), known.sum(0)])


def jackknife(sums: Float[np.ndarray, "3 2 samples"]) -> float:
    """Standard error of `first_order_misfit` [1], by leaving out one sample at a time."""
    whole = sums.sum(-1)
    each = np.array([first_order_misfit(whole - sums[:, :, n]) for n in range(sums.shape[-1])])
    return float(np.sqrt((len(each) - 1) / len(each) * np.sum((each - each.mean()) ** 2)))


def first_order_misfit(sums: Float[np.ndarray, "3 2"]) -> float:
    """By how much d3/d1 is not what d1 and d2 foretell [1]."""
    one, two, three = sums[:, 0] / sums[:, 1]
    r = two / one - 1
    return float(three / one - (1 + r + r**2))

"""How far a camera's clock is off: when it sees the heater switched on and off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike
from scipy import stats

from thermo.errors import InputError
from thermo.observe import check_number, check_time, real_array

_PART: Final = 0.5
"""Samples are averaged over where they respond by this part of the most responsive ones [1]."""

_POWERS: Final = (0.5, 1.0)
"""Onsets that are tried: of a thick body under constant flux, and of a thin one [1]."""

_COARSE: Final = 4
"""Offsets that are tried within one frame's time [1]."""

_FINE: Final = 50
"""Offsets that are tried on either side of the best one at the end [1]."""

_LEAST: Final = 5
"""Fewest frames before and after a switch [1]."""

_KNOWN: Final = 0.9
"""Values that a sample must have [1]."""

_SURE: Final = 1e-3
"""Chance that there is no onset, above which none is seen [1]."""


@final
class TimeOffset(eqx.Module):
    """When a camera sees the heater switched, against what was stated.

    Arguments:

    - `offset`: the camera sees the switches this much later than stated [s]; take it from the
      camera's times.
    - `deviation`: one standard deviation of it [s].
    - `p_value`: chance of such an onset in noise alone, at the most [1].
    - `power`: of the onset over time: 0.5 as of a thick body, 1 as of a thin one [1].
    - `rises`: change by each switch to the end of its window, (switches,) [K].
    - `samples`: those averaged over, (samples,).
    """

    offset: float
    deviation: float
    p_value: float
    power: float
    rises: Float[np.ndarray, " switches"]
    samples: Bool[np.ndarray, " samples"]


@final
class _Window(eqx.Module):
    """Frames about a switch: times from it [s] and mean temperatures (frames,) [K]."""

    time: Float[np.ndarray, " frames"]
    mean: Float[np.ndarray, " frames"]


def time_offset(
    time: ArrayLike,
    temperature: ArrayLike,
    switches: Sequence[float | int],
    *,
    most: float = 5.0,
    window: float = 10.0,
    where: str = "recording",
) -> TimeOffset:
    """Find how much later than stated a camera sees a heater switched on and off.

    Over a window about each switch at s the mean of the most responsive samples follows

    T(t) = b + c (t - s) + e (t - s)^2 + a x^p + d x^(2 p), x = max(t - s - o, 0),

    with p = 1/2 as the surface of a half-space under a constant flux warms, or p = 1 as a thin
    body does; the second power is what either loses by and by, and the square what goes on from
    before, as on heating where the heater is switched off. b, c, e, a, d are free for each switch
    and the offset o is common. The sum of squares over o and p is least at what is returned; the
    deviation is half the width in o within which the sum of either p rises by less than the
    residuals' variance, which counts (1 + r) / (1 - r) times for residuals whose neighbours
    correlate by r > 0. Samples are chosen in every other frame and the chance of no onset is taken
    from the others, by the F statistic times the number of onsets tried.

    Arguments:

    - `time`: of the frames, (frames,) [s].
    - `temperature`: (frames, samples) [K], NaN where there is none.
    - `switches`: stated times at which the heater was switched on or off [s].
    - `most`: how large the offset may be [s].
    - `window`: seconds looked at before and after, less where another switch is near [s].
    - `where`: what messages call the recording.

    Raises `InputError` where the frames do not reach over a switch, where no onset is seen (the
    chance of one in noise is above 0.001), and where the offset is at its limit.

    Source: Carslaw and Jaeger, Conduction of Heat in Solids (1959), 2.9, equation 7 (constant
    flux).
    """
    time = check_time(time, where=f"{where}: time", earliest=None)
    values = _values(temperature, len(time), where)
    check_number(most, where="most", quantity="largest offset [s]", above=0.0)
    check_number(window, where="window", quantity="window [s]", above=most)
    spans = _spans(time, switches, most, window, where)
    step = float(np.median(np.diff(time)))
    grid = np.arange(-most, most + step / (2 * _COARSE), step / _COARSE)
    chosen = _responsive(time, values, switches, spans)
    windows = _windows(time, values, chosen, switches, spans)
    chance = _chance([_Window(w.time[1::2], w.mean[1::2]) for w in windows], grid)
    if not chance < _SURE:
        raise InputError(
            "no onset of heating is seen", where=where, value=f"chance of noise {chance:.2g}",
            limit=f"less than {_SURE:g}",
            remedy="check the times of the switches, or give samples that the heater reaches",
        )  # fmt: skip
    offset, deviation, power = _best(windows, grid, step)
    _check_limit(offset, most - step, where)
    rises = np.array([_rise(window, offset, power) for window in windows])
    return TimeOffset(offset, deviation, chance, power, rises, chosen)


def _check_limit(offset: float, most: float, where: str) -> None:
    if abs(offset) > most:
        raise InputError(
            "the offset is at its limit", where=where, value=f"{offset:.3g} s",
            limit=f"less than {most:g} s", remedy="allow for more, or check the stated times",
        )  # fmt: skip


def _values(temperature: object, frames: int, where: str) -> Float[np.ndarray, "frames samples"]:
    values = real_array(temperature, where=f"{where}: temperature", quantity="temperature [K]")
    if values.ndim != 2 or len(values) != frames or values.shape[1] == 0:
        raise InputError(
            "temperature does not fit time", where=f"{where}: temperature",
            value=f"shape {values.shape}", limit=f"shape ({frames}, samples)",
            remedy="store one row a frame and one column a sample",
        )  # fmt: skip
    return values


def _spans(
    time: Float[np.ndarray, " frames"],
    switches: Sequence[float | int],
    most: float,
    window: float,
    where: str,
) -> list[Bool[np.ndarray, " frames"]]:
    """Which frames belong to each switch."""
    if not switches or not np.isfinite(np.asarray(switches, float)).all():
        raise InputError(
            "no switch of the heater is stated", where="switches", value=list(switches),
            limit="finite times [s], at least one", remedy="state when the heater was switched",
        )  # fmt: skip
    ordered, found = np.sort(np.asarray(switches, float)), []
    for at in switches:
        others = ordered[ordered != at]
        # Where two switches are near, each is looked at to where the other may begin.
        before = max((one + most for one in others if one < at), default=-np.inf)
        after = min((one - most for one in others if one > at), default=np.inf)
        span = (time >= max(at - window, before)) & (time <= min(at + window, after))
        fits = int((span & (time < at - most)).sum()), int((span & (time > at + most)).sum())
        if min(fits) < _LEAST:
            raise InputError(
                "too few frames about a switch", where=f"{where}: switch at {at:g} s",
                value=f"{fits[0]} before {at - most:g} s and {fits[1]} after {at + most:g} s",
                limit=f"at least {_LEAST} on either side, apart from other switches",
                remedy="give less for `most`, leave this switch out, or record from earlier on",
            )  # fmt: skip
        found.append(span)
    return found


def _responsive(
    time: Float[np.ndarray, " frames"],
    values: Float[np.ndarray, "frames samples"],
    switches: Sequence[float | int],
    spans: Sequence[Bool[np.ndarray, " frames"]],
) -> Bool[np.ndarray, " samples"]:
    """Samples whose slope changes about as much as of any, in every other frame."""
    change, seen = np.zeros(values.shape[1]), np.ones(values.shape[1], bool)
    for at, span in zip(switches, spans, strict=True):
        late, shown = time[span][0::2] - at, values[span][0::2]
        known = np.isfinite(shown)
        seen &= np.isfinite(values[span]).mean(axis=0) >= _KNOWN
        mean = np.where(known, shown, 0.0).sum(0) / np.maximum(known.sum(0), 1)
        base = np.stack([np.ones(len(late)), late, np.maximum(late, 0.0)], axis=1)
        found, *_ = np.linalg.lstsq(base, np.where(known, shown, mean), rcond=None)
        change += (found[2] * late[-1]) ** 2
    if not seen.any():
        raise InputError(
            "no sample is seen about every switch", where="temperature",
            value="values missing in every sample", limit=f"a sample with {_KNOWN:.0%} of them",
            remedy="give samples that stay in view",
        )  # fmt: skip
    return seen & (np.sqrt(change) >= _PART * np.quantile(np.sqrt(change[seen]), 0.95))


def _windows(
    time: Float[np.ndarray, " frames"],
    values: Float[np.ndarray, "frames samples"],
    chosen: Bool[np.ndarray, " samples"],
    switches: Sequence[float | int],
    spans: Sequence[Bool[np.ndarray, " frames"]],
) -> list[_Window]:
    """Mean course about each switch; missing values are interpolated, so that the mean is even."""
    found = []
    for at, span in zip(switches, spans, strict=True):
        late, shown = time[span] - at, values[span][:, chosen].copy()
        for column in shown.T:
            known = np.isfinite(column)
            column[~known] = np.interp(late[~known], late[known], column[known])
        found.append(_Window(late, shown.mean(axis=1)))
    return found


def _basis(
    window: _Window, offsets: Float[np.ndarray, " offsets"], power: float
) -> Float[np.ndarray, "offsets frames five"]:
    """The parabola and both powers of the onset [1], for each offset [s]; times over the window."""
    whole = np.abs(window.time).max()
    now = window.time / whole
    late = np.maximum(now - offsets[:, None] / whole, 0.0)
    before = np.broadcast_to(np.stack([np.ones(len(now)), now, now**2], -1), (*late.shape, 3))
    return np.concatenate([before, np.stack([late**power, late ** (2 * power)], -1)], axis=-1)


def _sums(
    windows: Sequence[_Window], offsets: Float[np.ndarray, " offsets"], power: float
) -> Float[np.ndarray, " offsets"]:
    """Sum of squares [K2] that each offset [s] leaves."""
    total = np.zeros(len(offsets))
    for window in windows:
        across, _ = np.linalg.qr(_basis(window, offsets, power))
        data = window.mean - window.mean.mean()
        left = data - np.einsum("ofk,ok->of", across, np.einsum("ofk,f->ok", across, data))
        total += (left**2).sum(axis=1)
    return total


def _left(
    window: _Window, offset: float, power: float
) -> tuple[Float[np.ndarray, " frames"], Float[np.ndarray, " five"]]:
    """What an offset [s] leaves [K], and the five factors [K]."""
    base = _basis(window, np.array([offset]), power)[0]
    found, *_ = np.linalg.lstsq(base, window.mean, rcond=None)
    return window.mean - base @ found, found


def _parabola(window: _Window) -> Float[np.ndarray, " frames"]:
    """What a course without onset leaves [K]."""
    line = np.polynomial.Polynomial.fit(window.time, window.mean, 2)
    return window.mean - line(window.time)


def _rise(window: _Window, offset: float, power: float) -> float:
    """What the onset adds up to at the end of the window [K]."""
    base = _basis(window, np.array([offset]), power)[0]
    return float(base[-1, 3:] @ _left(window, offset, power)[1][3:])


def _chance(windows: Sequence[_Window], grid: Float[np.ndarray, " offsets"]) -> float:
    """Chance of so good an onset in noise, by Bonferroni over all that were tried [1]."""
    plain = sum(float((_parabola(window) ** 2).sum()) for window in windows)
    left = min(float(_sums(windows, grid, power).min()) for power in _POWERS)
    free = sum(len(window.time) for window in windows) - 5 * len(windows)
    if free < 1:
        return 1.0
    ratio = (plain - left) / (2 * len(windows)) / max(left / free, 1e-300)
    return min(1.0, len(_POWERS) * len(grid) * float(stats.f.sf(ratio, 2 * len(windows), free)))


def _best(
    windows: Sequence[_Window], grid: Float[np.ndarray, " offsets"], step: float
) -> tuple[float, float, float]:
    """Offset [s], its deviation [s] and the onset's power."""
    tried = {power: _sums(windows, grid, power) for power in _POWERS}
    power = min(tried, key=lambda p: float(tried[p].min()))
    centre, reach = grid[int(np.argmin(tried[power]))], 2 * step / _COARSE
    left = tried[power]
    for _ in range(3):
        fine = centre + reach * np.linspace(-1, 1, 2 * _FINE + 1)
        left = _sums(windows, fine, power)
        centre, reach = fine[int(np.argmin(left))], reach / 10
    least = float(left.min())
    free = sum(len(window.time) for window in windows) - 5 * len(windows) - 1
    variance = least / max(free, 1) * _correlation(windows, float(centre), power)
    within = [centre]
    for width in (step * 2.0**k for k in range(-10, 12)):
        near = centre + width * np.linspace(-1, 1, 2 * _FINE + 1)
        sums = np.minimum(*(_sums(windows, near, p) for p in _POWERS))
        under = near[sums <= least + variance]
        within += [under.min(), under.max()] if under.size else []
        if not under.size or (under.min() > near[0] and under.max() < near[-1]):
            break
    # Nothing finer than what was tried is told.
    deviation = max((max(within) - min(within)) / 2, 1e-3 * step)
    return float(centre), float(deviation), power


def _correlation(windows: Sequence[_Window], offset: float, power: float) -> float:
    """(1 + r) / (1 - r) for the correlation r of what is left in neighbouring frames [1]."""
    above = below = 0.0
    for window in windows:
        left, _ = _left(window, offset, power)
        above += float((left[1:] * left[:-1]).sum())
        below += float((left**2).sum())
    together = np.clip(above / max(below, 1e-300), 0.0, 0.95)
    return float((1 + together) / (1 - together))

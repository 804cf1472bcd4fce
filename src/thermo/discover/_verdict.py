"""What a search found, in words and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, final

import numpy as np
from jaxtyping import Float

from thermo.discover._calibration import Calibration
from thermo.discover._candidate import Candidate, Card, Inclusion
from thermo.discover._misfit import Misfit
from thermo.discover._power import Power
from thermo.discover._trace import Trace
from thermo.inverse import Estimate


@final
@dataclass(frozen=True)
class Effect:
    """An effect that was put to work.

    - `card`; `strength`, `sd`, `interval95`: in the card's unit.
    - `centre`: (3,) [m], `size`: [m]; None where the effect has no place. The nearest point of the
      surface where the middle of its shape lies beside the body.
    - `chance`: of strengths as large by the scatter of the fit alone, all of a joint effect [1].
    - `transition`: middle and width on the scale of temperature [K], or None.
    - `conductance`: over all of its place [W/K], and in which interval it is in 95 % of cases; None
      where it adds no convection and no contact.
    - `strengths`: of a joint effect, as a history, all in their order; `strength` is the last.
    - `side`: as "+x", of what is at a side of the body; `depth`: from its end, or from the skin, to
      which an effect without a centre reaches [m].
    - `outline`: one place [m], where the effect ends at an edge; else None.
    - `part`: which of its kind it is, in words, as "along z"; None where the kind has one alone.
    """

    card: Card
    strength: float
    sd: float
    interval95: tuple[float, float]
    centre: Float[np.ndarray, "3"] | None
    size: float | None
    transition: tuple[float, float] | None = None
    conductance: float | None = None
    conductance95: tuple[float, float] | None = None
    strengths: tuple[float, ...] = ()
    side: str | None = None
    depth: float | None = None
    outline: Inclusion | None = None
    part: str | None = None
    chance: float = field(kw_only=True)


@final
@dataclass(frozen=True)
class Candidacy:
    """What the data said of one kind of effect in a round.

    - `score`: in standard deviations [1]; `strength`, `sd`: predicted, in the card's unit.
    - `visible`: share of its signature that the unknowns do not swallow [1].
    - `left`: share of what the best explains that it does not [1]; None where it was not refitted.
    - `correlation`: of what is left with its signature, as it is [1]; `bic`: Schwarz's criterion of
      its refit less that without it [1], None where it was not refitted.
    """

    card: Card
    score: float
    strength: float
    sd: float
    visible: float
    left: float | None
    correlation: float
    bic: float | None


@final
@dataclass(frozen=True)
class Alternative:
    """What would explain as much as the best of a round, fitted in its place.

    - `effect`; `rms`: what it leaves, by run [K].
    - `parameters`: values of the fields with it, and in which interval they are in 95 % of cases
      [SI].
    - `held_out`: what it leaves on runs that were not fitted, as `HeldOut.rms_after` [K]; nothing
      where it was not predicted there.
    """

    effect: Effect
    parameters: Mapping[str, tuple[float, tuple[float, float]]]
    rms: Mapping[str, float]
    held_out: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Round:
    """One effect more.

    - `candidates`: all kinds, the best part of each; `threshold`: of their scores [1].
    - `effect`: the best; `together`: names of all that would explain as much; `alternatives`: these
      but the best by name, beside what was found before, or beside all where that was tried.
    - `p_value`: that of all that was scored noise makes one explain as much [1].
    - `rms_before`, `rms_after`: by run [K].
    - `closed`: share of what is beyond noise that it closes [1].
    """

    candidates: list[Candidacy] = field(repr=False)
    threshold: float
    effect: Effect
    together: list[str]
    p_value: float
    rms_before: Mapping[str, float]
    rms_after: Mapping[str, float]
    closed: float
    alternatives: Mapping[str, Alternative] = field(repr=False)


@final
@dataclass(frozen=True)
class Differences:
    """Simulation less readings of a run, constant errors of samples taken off.

    - `time`: (frames,) [s]; `points`: (samples, 3) [m].
    - `before`, `after`: (frames, samples) [K], NaN where nothing was read.
    """

    time: Float[np.ndarray, " frames"]
    points: Float[np.ndarray, "samples 3"]
    before: Float[np.ndarray, "frames samples"]
    after: Float[np.ndarray, "frames samples"]


@final
@dataclass(frozen=True)
class HeldOut:
    """A run that was not fitted.

    - `rms_before`, `rms_after`: of differences, each sample's constant error taken off; `noise`:
      what a model that is right leaves of them, which has what is not known of those errors [K].
    - `gap_closed`: share of the squares beyond noise [1], None where there are none;
      `interval95`: of that share were other samples read, and noise told anew, None where too few
      are.
    - `doubt`: deviation of the variance of noise as it was told, over that variance [1].
    - `differences`: of which those are the root mean squares [K].
    """

    rms_before: float
    rms_after: float
    noise: float
    gap_closed: float | None
    interval95: tuple[float, float] | None
    doubt: float
    differences: Differences = field(repr=False)


Word = Literal["named", "inseparable", "none_of_mine", "no_gap"]


@final
@dataclass(frozen=True)
class Verdict:
    """The answer, and what it rests on. Its `repr` is short: what would be pages is left out.

    - `verdict`; `rounds`: of what is named, or of the best that does not explain the gap.
    - `held_out`: by run; `missed`: by kind the strengths that would have been found, beside what
      was stated.
    - `cells`: what a fit's usual cells and steps make wrong, by run [K]; it is taken off, and a
      third of it is allowed for.
    - `noise`: of a reading by run [K].
    - `parameters`: values of the fields before and after [SI]; `intervals`, in which those after
      are in 95 % of cases: none where nothing explains the gap.
    - `alias`: how alike the best parts of two kinds are, beside the unknowns [1].
    - `omnibus`: probability of as large a misfit in smooth shapes without and with effects [1].
    - `calibration`: how often an alarm would be false on such runs, by simulation [1].
    - `misfits`: by run where what is left lies, without and with effects; `traces`: whether it is
      white over time there, and what of the run it follows.
    - `stated`, `extended`: fields [SI] and runs [K] of the fits without and with what was found;
      `additions`: what was found, as modules. Nothing, where none explains the gap.
    """

    verdict: Word
    rounds: list[Round]
    candidates: list[Candidacy] = field(repr=False)
    threshold: float
    held_out: Mapping[str, HeldOut]
    missed: Mapping[str, Power] = field(repr=False)
    cells: Mapping[str, float]
    noise: Mapping[str, float]
    parameters: Mapping[str, tuple[float, float]]
    intervals: Mapping[str, tuple[float, float]]
    alias: Mapping[str, Mapping[str, float]] = field(repr=False)
    omnibus: tuple[float, float]
    calibration: Calibration = field(repr=False)
    misfits: tuple[Mapping[str, Misfit], Mapping[str, Misfit]] = field(repr=False)
    traces: tuple[Mapping[str, Trace], Mapping[str, Trace]] = field(repr=False)
    stated: Estimate = field(repr=False)
    extended: Estimate = field(repr=False)
    additions: tuple[Candidate, ...] = field(repr=False)
    remarks: list[str] = field(default_factory=list)

    def effects(self) -> list[str]:
        """Names of what was found, in the order in which it was."""
        if self.verdict not in ("named", "inseparable"):
            return []
        return [one.effect.card.name for one in self.rounds]

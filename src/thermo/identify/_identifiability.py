"""What the data identify: verdicts, free combinations and what looks alike, together."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import final

from thermo.identify._collinearity import Alike, alike
from thermo.identify._combination import Combination, listed
from thermo.identify._finding import Finding, findings
from thermo.identify._spectrum import Spectrum, spectrum
from thermo.inverse import Sensitivity


@final
@dataclass(frozen=True)
class Identifiability:
    """What runs tell of the unknowns, as far as slopes at one point say.

    - `findings`: a verdict on each unknown; `free`: combinations that the data leave to the prior.
    - `alike`: sets of unknowns whose effects make up for each other; `spectrum`: behind it all.
    - `wanted`: half-width of the 95 % interval of log(value) that counts as known [1].
    """

    findings: list[Finding]
    free: list[Combination]
    alike: list[Alike]
    spectrum: Spectrum
    wanted: float

    def sentences(self, *, before: bool = False, means: Collection[str] = ()) -> list[str]:
        """The verdict on each unknown and each free combination, in words.

        `before` a fit values are what is stated, and the rest is foretold. `means` names those
        whose values are means of fields.
        """
        known = "to be known" if before else "known"
        told = [
            f"The mean of {sentence}" if item.name in means else sentence
            for item in self.findings
            for sentence in [_sentence(item, known)]
        ]
        told += [f"The data leave to the prior: {one.words()}." for one in self.free]
        told += [
            f"{listed(one.names)} have effects that look alike "
            f"(index {one.index:.0f}): measure {one.measure}, for example."
            for one in self.alike
        ]
        return told


def identifiability(
    at: Sensitivity,
    *,
    prior: Mapping[str, float] | None = None,
    model_error: float = 0.01,
    wanted: float = 0.1,
) -> Identifiability:
    """What the data identify and what they do not.

    Arguments:

    - `at`: slopes of the temperatures [K], from before a fit or where it ended.
    - `prior`: by unknown, standard deviation of log(phi) before the data [1]; by default that of
      an even spread over its bounds.
    - `model_error`: what the simulation itself may be wrong by [K].
    - `wanted`: half-width of the 95 % interval of log(value) that counts as known [1].

    Raises `InputError` where one of them cannot be.
    """
    found = spectrum(at, prior=prior, model_error=model_error)
    told = findings(at, found, wanted=wanted, model_error=model_error)
    close = alike(at, model_error=model_error)
    return Identifiability(told, found.undetermined(), close, found, wanted)


def _sentence(item: Finding, known: str) -> str:
    size = f"{item.name} is {item.value:.4g} {'' if item.unit == '1' else item.unit}".rstrip()
    low, high = item.interval95
    span = f"95 % interval {low:.5g} to {high:.5g}"
    if item.verdict == "identified":
        return f"{size}, {known} to {196 * item.relative:.2g} % ({span})."
    if item.verdict == "weak":
        return f"{size}, {known} only to {196 * item.relative:.2g} % ({span})."
    if item.verdict == "at_bound":
        return f"{size}, at the bound of what is physical."
    why = "most of it the prior's" if item.informed < 0.5 else "with others that go along"
    return f"{item.name} is not identified by these runs ({span}, {why})."

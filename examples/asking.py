"""What the examples that ask for a missing effect share."""

from __future__ import annotations

from pathlib import Path

from thermo.discover import Candidate, Setting, Verdict, library
from thermo.discover.candidates import CameraDrift, CameraEmissivity
from thermo.report import discovery_record, write_discovery


def for_couples(setting: Setting) -> tuple[Candidate, ...]:
    """The library without what a camera may do wrong: thermocouples' readings."""
    camera = (CameraEmissivity, CameraDrift)
    return tuple(one for one in library(setting) if not isinstance(one, camera))


def tell(verdict: Verdict, name: str, out: Path) -> None:
    """Print what was found, round by round, and leave the page of the object of that name."""
    for number, one in enumerate(verdict.rounds, 1):
        low, high = one.effect.interval95
        print(
            f"round {number}: {' or '.join(one.together)}, {one.effect.strength:.3g} "
            f"{one.effect.card.unit} [{low:.3g}, {high:.3g}]"
        )
        for run, before in one.rms_before.items():
            print(f"  {run}: rms {before:.3f} to {one.rms_after[run]:.3f} K")
    for parameter, (before, after) in verdict.parameters.items():
        print(f"{parameter}: {before:.4g} before, {after:.4g} after")
    record = discovery_record(verdict) | {"object": name}
    print(*record["sentences"], sep="\n")
    write_discovery(out, verdict, record)
    print(f"page: {out / 'verdict.html'}")

"""Where simulation and measurement disagree: which effect is missing, and the proof."""

from thermo.discover._candidate import (
    AbstractHeatCandidate,
    AbstractReadingCandidate,
    Candidate,
    Card,
    Place,
)
from thermo.discover._discover import discover
from thermo.discover._library import library
from thermo.discover._verdict import Candidacy, Effect, HeldOut, Round, Verdict

__all__ = [
    "AbstractHeatCandidate",
    "AbstractReadingCandidate",
    "Candidacy",
    "Candidate",
    "Card",
    "Effect",
    "HeldOut",
    "Place",
    "Round",
    "Verdict",
    "discover",
    "library",
]

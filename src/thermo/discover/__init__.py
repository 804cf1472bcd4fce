"""Where simulation and measurement disagree: which effect is missing, and the proof."""

from thermo.discover._calibration import Calibration
from thermo.discover._candidate import (
    AbstractHeatCandidate,
    AbstractReadingCandidate,
    Candidate,
    Card,
    Inclusion,
    Place,
    Transition,
)
from thermo.discover._discover import discover
from thermo.discover._effects_file import effects_as_arrays, load_effects
from thermo.discover._library import Setting, library
from thermo.discover._memory import forget
from thermo.discover._misfit import Misfit, Part
from thermo.discover._power import SHARES, Power
from thermo.discover._registered import only, registered
from thermo.discover._stated_otherwise import stated_otherwise
from thermo.discover._trace import Follows, Trace
from thermo.discover._verdict import (
    Alternative,
    Candidacy,
    Differences,
    Effect,
    HeldOut,
    Round,
    Verdict,
)

__all__ = [
    "SHARES",
    "AbstractHeatCandidate",
    "AbstractReadingCandidate",
    "Transition",
    "Calibration",
    "Alternative",
    "Candidacy",
    "Candidate",
    "Card",
    "Differences",
    "Effect",
    "Follows",
    "HeldOut",
    "Inclusion",
    "Misfit",
    "Part",
    "Place",
    "Power",
    "Round",
    "Setting",
    "Trace",
    "Verdict",
    "discover",
    "effects_as_arrays",
    "forget",
    "library",
    "load_effects",
    "only",
    "registered",
    "stated_otherwise",
]

"""What the data can tell of the unknowns, and what they cannot."""

from thermo.identify._basins import Basins, basins
from thermo.identify._collinearity import Alike, alike
from thermo.identify._combination import Combination
from thermo.identify._expected_error import ExpectedError, expected_errors
from thermo.identify._field_finding import field_findings, field_sentences
from thermo.identify._finding import Finding, Verdict, findings
from thermo.identify._identifiability import Identifiability, identifiability
from thermo.identify._next_run import NextRun, next_runs
from thermo.identify._path import LEVEL, Model
from thermo.identify._profile import Profile, profile
from thermo.identify._region_mean import SURFACE, RegionMean, region_mean, region_profile
from thermo.identify._samples import Samples, samples
from thermo.identify._shift import Shift, shifts, unknowns_of
from thermo.identify._spectrum import Spectrum, spectrum
from thermo.identify._variance_split import VarianceSplit, split_variance

__all__ = [
    "LEVEL",
    "SURFACE",
    "Alike",
    "Basins",
    "Combination",
    "ExpectedError",
    "Finding",
    "Identifiability",
    "Model",
    "NextRun",
    "Profile",
    "RegionMean",
    "Samples",
    "Shift",
    "Spectrum",
    "VarianceSplit",
    "Verdict",
    "alike",
    "basins",
    "expected_errors",
    "field_findings",
    "field_sentences",
    "findings",
    "identifiability",
    "next_runs",
    "profile",
    "region_mean",
    "region_profile",
    "samples",
    "shifts",
    "spectrum",
    "split_variance",
    "unknowns_of",
]

"""What the data can tell of the unknowns, and what they cannot."""

from thermo.identify._expected_error import ExpectedError, expected_errors
from thermo.identify._variance_split import VarianceSplit, split_variance

__all__ = ["ExpectedError", "VarianceSplit", "expected_errors", "split_variance"]

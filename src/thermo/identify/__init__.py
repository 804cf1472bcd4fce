"""What the data can tell of the unknowns, and what they cannot."""

from thermo.identify._expected_error import ExpectedError, expected_errors

__all__ = ["ExpectedError", "expected_errors"]

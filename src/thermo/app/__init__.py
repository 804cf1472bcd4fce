"""The `thermo` command."""

from thermo.app._command import main

__all__ = ["main"]

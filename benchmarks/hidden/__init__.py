"""Recordings with hidden effects, made by scikit-fem, and what `thermo.discover` says of them."""

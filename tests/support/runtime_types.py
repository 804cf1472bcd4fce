"""The checker of annotations that `tests/conftest.py` hands to jaxtyping."""

from __future__ import annotations

from beartype import BeartypeConf, beartype

# A whole number may stand where a float is asked for, as in every static checker.
check = beartype(conf=BeartypeConf(is_pep484_tower=True))

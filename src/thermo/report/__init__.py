"""What a run leaves: JSON, arrays, ParaView files and figures; tables and progress on the way."""

from ._field_record import band_record, field_record, surface_record, write_fields_left
from ._figure_curves import figure_curves
from ._figure_field import figure_field
from ._figure_history import figure_history
from ._figure_residuals import figure_residuals
from ._figure_robustness import RepeatedFits, figure_robustness
from ._figure_transfer import TransferMap, figure_transfer
from ._folder import require_writable
from ._json import write_json
from ._npz import write_npz
from ._progress import Progress
from ._table import table
from ._text import write_text
from ._versions import versions
from ._vtk import write_pvd, write_vtu
from ._write_discovery import discovery_record, discovery_table, write_discovery
from ._write_identifiability import (
    identifiability_record,
    identifiability_table,
    write_identifiability,
)
from ._write_inversion import inversion_record, inversion_table, write_inversion
from ._write_prediction import prediction_table, write_predictions

__all__ = [
    "discovery_record",
    "discovery_table",
    "write_discovery",
    "Progress",
    "RepeatedFits",
    "TransferMap",
    "band_record",
    "field_record",
    "figure_curves",
    "figure_field",
    "figure_history",
    "figure_residuals",
    "figure_robustness",
    "figure_transfer",
    "identifiability_record",
    "identifiability_table",
    "inversion_record",
    "inversion_table",
    "prediction_table",
    "require_writable",
    "surface_record",
    "table",
    "versions",
    "write_fields_left",
    "write_identifiability",
    "write_inversion",
    "write_json",
    "write_npz",
    "write_predictions",
    "write_pvd",
    "write_text",
    "write_vtu",
]

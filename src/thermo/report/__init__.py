"""What a run leaves: JSON, arrays, ParaView files and figures; tables and progress on the way."""

from ._claim import claimed
from ._field_record import band_record, field_record, surface_record, write_fields_left
from ._figure_curves import figure_curves
from ._figure_field import figure_field
from ._figure_history import figure_history
from ._figure_rendering import figure_rendering
from ._figure_residuals import figure_residuals
from ._figure_robustness import RepeatedFits, figure_robustness
from ._figure_transfer import TransferMap, figure_transfer
from ._figure_turntable import figure_turntable, upward
from ._folder import require_writable
from ._json import write_json
from ._live import log_to_rerun
from ._npz import write_npz
from ._progress import Progress, say_to
from ._table import table
from ._text import write_text
from ._versions import versions
from ._viewer import Layer, Readings, Viewer
from ._viewer_page import write_viewer
from ._viewer_prediction import viewer_of_prediction
from ._vtk import write_pvd, write_vtu
from ._write_discovery import discovery_record, discovery_table, write_discovery
from ._write_identifiability import (
    identifiability_record,
    identifiability_table,
    mean_record,
    write_identifiability,
)
from ._write_inversion import inversion_record, inversion_table, write_inversion
from ._write_prediction import cells_wrong, prediction_table, write_predictions
from ._write_reconstruction import write_reconstruction
from ._write_registration import write_registration

__all__ = [
    "cells_wrong",
    "Layer",
    "Progress",
    "Readings",
    "RepeatedFits",
    "TransferMap",
    "Viewer",
    "band_record",
    "claimed",
    "discovery_record",
    "discovery_table",
    "field_record",
    "figure_curves",
    "figure_field",
    "figure_history",
    "figure_rendering",
    "figure_residuals",
    "figure_robustness",
    "figure_transfer",
    "figure_turntable",
    "identifiability_record",
    "identifiability_table",
    "inversion_record",
    "inversion_table",
    "log_to_rerun",
    "mean_record",
    "prediction_table",
    "require_writable",
    "say_to",
    "surface_record",
    "table",
    "upward",
    "versions",
    "viewer_of_prediction",
    "write_discovery",
    "write_fields_left",
    "write_identifiability",
    "write_inversion",
    "write_json",
    "write_npz",
    "write_predictions",
    "write_pvd",
    "write_reconstruction",
    "write_registration",
    "write_text",
    "write_viewer",
    "write_vtu",
]

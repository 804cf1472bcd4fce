"""What was measured: scenes, recordings, prescribed histories and the noise in them.

A scene folder in the format `thermofield-scene/1` holds `scene.json`, one surface file and one
recording a run. Everything is SI and temperatures are in kelvin. `read_scene` documents the keys,
`read_recording` the two file types (NPZ, and CSV in long or wide form).
"""

from __future__ import annotations

from ._air import Air
from ._atomic import replacing, write_whole
from ._binding import bind
from ._box import Box
from ._camera_noise import with_camera_noise
from ._course import Course
from ._csv_table import LENGTH, TIME, csv_lines, read_table
from ._distance import check_distance
from ._heater import Heater
from ._kelvin import COLDEST, HOTTEST, check_kelvin
from ._noise import Noise, estimate_noise, variance_error
from ._npz import npz_array, open_npz, read_npz
from ._number import check_number, real_array
from ._prescribed import Prescribed, read_history
from ._quiet_check import QuietCheck, check_quiet
from ._recording import Recording, check_time
from ._recording_read import read_recording
from ._recording_write import write_recording
from ._residual_noise import ResidualNoise, residual_noise
from ._scene import QUANTITIES, Run, Scene, StatedMaterial
from ._scene_read import FORMAT, read_scene
from ._scene_write import write_scene
from ._spikes import without_spikes
from ._temperature_table import REFERENCE, TemperatureTable
from ._view import seen_from

__all__ = [
    "COLDEST",
    "FORMAT",
    "HOTTEST",
    "LENGTH",
    "QUANTITIES",
    "REFERENCE",
    "TIME",
    "Air",
    "Box",
    "Course",
    "Heater",
    "Noise",
    "Prescribed",
    "QuietCheck",
    "Recording",
    "ResidualNoise",
    "Run",
    "Scene",
    "StatedMaterial",
    "TemperatureTable",
    "bind",
    "check_distance",
    "check_kelvin",
    "check_number",
    "check_quiet",
    "check_time",
    "csv_lines",
    "estimate_noise",
    "npz_array",
    "open_npz",
    "read_history",
    "read_npz",
    "read_recording",
    "read_scene",
    "read_table",
    "real_array",
    "replacing",
    "residual_noise",
    "seen_from",
    "variance_error",
    "with_camera_noise",
    "without_spikes",
    "write_recording",
    "write_scene",
    "write_whole",
]

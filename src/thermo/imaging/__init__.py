"""Cameras and what they record: frames brought to a surface, and pictures of a surface.

A pixel's centre is at whole numbers, the first at (0, 0), columns first. Cameras look along their
own z axis, x to the right and y down, whatever the file they were read from says.
"""

from __future__ import annotations

from ._align_points import PointAlignment, align_to_points
from ._align_silhouettes import Alignment, align_to_silhouettes
from ._band import Band
from ._camera import Camera, pixel_centres, project, rays
from ._colours import COLOUR_MAPS, Colours, coloured
from ._coverage import coverage
from ._error_budget import Deviations, ErrorBudget, sensitivities, uncertainty
from ._film import write_film
from ._frame_faults import FrameFaults, find_faults, without_faults
from ._frames import Frames
from ._fusion import check_count, check_frames, fused, register_frames
from ._interpolate import NEAREST, SampleWeights, interpolated, sample_weights
from ._looks import Looks, look_all, looks_of
from ._middlebury import write_middlebury
from ._optics import Optics
from ._order import better_order, contours_apart
from ._pixel_map import PixelMap, depth_at, look
from ._planck import PlanckConstants
from ._point_cloud import check_cloud, read_points
from ._pose import Axes, camera_to_world, looking_at, world_to_camera
from ._radiometry import (
    apparent_temperature,
    measured_signal,
    temperature_from_signal,
    true_temperature,
)
from ._read_cameras import read_cameras
from ._read_frames import read_frames
from ._refined import refined
from ._render import render
from ._render_bar import Degrees, colour_bar, with_bar
from ._render_writers import write_picture
from ._response import AbstractResponse, signal_of, slope_of, temperature_of
from ._rig import Rig, read_rig, rig_from_poses, thermal_views, write_rig
from ._silhouette import mask_of, overlap, silhouette
from ._similarity import Similarity, motion_about, similarity_about
from ._surface_samples import SurfaceSamples, place_samples, samples_at
from ._time_offset import TimeOffset, time_offset
from ._transforms_json import write_transforms
from ._true_frames import to_temperature
from ._usable import footprint, usable_pixels
from ._view import View
from ._visibility import depth_tolerance, seen_by_depth, seen_exactly
from .readers import AbstractReader, Stated

__all__ = [
    "COLOUR_MAPS",
    "NEAREST",
    "AbstractReader",
    "AbstractResponse",
    "Alignment",
    "Axes",
    "Band",
    "Camera",
    "Colours",
    "Degrees",
    "Deviations",
    "ErrorBudget",
    "FrameFaults",
    "Frames",
    "Looks",
    "Optics",
    "PixelMap",
    "PlanckConstants",
    "PointAlignment",
    "Rig",
    "SampleWeights",
    "Similarity",
    "Stated",
    "SurfaceSamples",
    "TimeOffset",
    "View",
    "align_to_points",
    "align_to_silhouettes",
    "apparent_temperature",
    "better_order",
    "contours_apart",
    "camera_to_world",
    "check_cloud",
    "check_count",
    "check_frames",
    "colour_bar",
    "coloured",
    "coverage",
    "depth_at",
    "depth_tolerance",
    "find_faults",
    "footprint",
    "fused",
    "interpolated",
    "look",
    "look_all",
    "looking_at",
    "looks_of",
    "mask_of",
    "measured_signal",
    "motion_about",
    "overlap",
    "pixel_centres",
    "place_samples",
    "project",
    "rays",
    "read_cameras",
    "read_frames",
    "read_points",
    "read_rig",
    "refined",
    "register_frames",
    "render",
    "rig_from_poses",
    "sample_weights",
    "samples_at",
    "seen_by_depth",
    "seen_exactly",
    "sensitivities",
    "signal_of",
    "silhouette",
    "similarity_about",
    "slope_of",
    "temperature_from_signal",
    "temperature_of",
    "thermal_views",
    "time_offset",
    "to_temperature",
    "true_temperature",
    "uncertainty",
    "usable_pixels",
    "with_bar",
    "without_faults",
    "world_to_camera",
    "write_film",
    "write_middlebury",
    "write_picture",
    "write_rig",
    "write_transforms",
]

"""From photographs to a metric surface: a signed distance learned by volume rendering."""

from __future__ import annotations

from ._extract_surface import extract_surface
from ._finding import Finding
from ._masks import masked_by_threshold, threshold_of
from ._metric_scale import (
    MetricScale,
    scale_from_depths,
    scale_from_distances,
    scale_from_length,
)
from ._objective import Balance
from ._photograph import Photograph
from ._picture import Picture, picture, psnr
from ._preflight import preflight
from ._read_photographs import read_photographs
from ._reconstruct import Reconstruction, reconstruct
from ._region import Region, region_of
from ._render_rays import Sampling
from ._train import Trained, distance_of, train
from ._training import Training

__all__ = [
    "Balance",
    "Finding",
    "MetricScale",
    "Photograph",
    "Picture",
    "Reconstruction",
    "Region",
    "Sampling",
    "Trained",
    "Training",
    "distance_of",
    "extract_surface",
    "masked_by_threshold",
    "picture",
    "preflight",
    "psnr",
    "read_photographs",
    "reconstruct",
    "region_of",
    "scale_from_depths",
    "scale_from_distances",
    "scale_from_length",
    "threshold_of",
    "train",
]

"""How near a result is to the truth: the numbers of Section 5, and those that no histogram can game.

Appearance transfer matches intensities and the sub-bands of a steerable pyramid, so a made view scores well
in these two by construction: they are reported, but never rank. The independent numbers look at patches, the
power spectrum, filaments and the length of outlines.

Pictures are (rows, columns), top row first, white at 255. The candidate comes first, the truth second.
"""

from warpfluid.metrics.motion import left_over
from warpfluid.metrics.pictures import psnr, ssim
from warpfluid.metrics.table import METRICS, SMALLEST_SIDE, Metric, appearance_distance, compare_pictures
from warpfluid.metrics.volumes import grid_index

__all__ = [
    "METRICS",
    "SMALLEST_SIDE",
    "Metric",
    "appearance_distance",
    "compare_pictures",
    "grid_index",
    "left_over",
    "psnr",
    "ssim",
]

"""Portilla and Simoncelli's statistics in the M-step: the paper's future work, for structures that histograms scatter.

A view is projected, from coarse to fine, onto the images that have one group of statistics after the other, as in the
published algorithm; a few sweeps bring all of them near. The targets are interpolated between the two inputs that the
view lies between. As in the paper's own M-step, intensities are matched last, so that black stays black.
"""

import numpy as np

from warpfluid.reconstruction import moments
from warpfluid.reconstruction.analytic_pyramid import AnalyticPyramid
from warpfluid.reconstruction.fan import match_intensities, modify_views, pad_views
from warpfluid.reconstruction.histogram import mix_neighbours
from warpfluid.reconstruction.joint_statistics import Statistics, magnitudes, measure, mix, parents, rows
from warpfluid.reconstruction.neighbours import around, between
from warpfluid.reconstruction.pyramid import default_height, padded_shape

TINY = 1e-6
AT_ONCE = 4  # views at a time


class PortillaSimoncelli:
    """The M-step of a fan of views that sets joint statistics. The targets are worked out once.

    Args:
        images: Input images, shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].
        fan_deg: Angles of the views to transfer to, in [0, 180) [degree].
        height: Scales of the pyramid; from the picture's size when omitted.
        sweeps: Over all statistics.
    """

    def __init__(
        self,
        images: np.ndarray,
        angles_deg: tuple[float, ...],
        fan_deg: tuple[float, ...],
        *,
        height: int | None = None,
        sweeps: int = 2,
    ):
        size, self._sweeps = images.shape[1:], sweeps
        self.pyramid = AnalyticPyramid(padded_shape(size), height or default_height(size))
        images, angles = around(images, angles_deg)
        images = pad_views(images, self.pyramid.shape)
        left, parts = between(angles, fan_deg)
        found = measure(self.pyramid, images)
        self.targets = mix(rows(found, left), rows(found, left + 1), parts)
        self._grey, self._ranks = mix_neighbours(images, left, parts, "density")

    def transfer(self, rendered: np.ndarray, mask: np.ndarray) -> np.ndarray:
        """Modify rendered views so that they have the statistics of the inputs.

        Args:
            rendered: One view for each angle of the fan, shape (angle, u, v).
            mask: Projection of the visual hull, bool, shape of ``rendered``; outside it the result is 0.

        Returns:
            The modified views, shape of ``rendered``; the same for any number of threads.
        """
        return modify_views(self._transfer_some, rendered, mask, at_once=AT_ONCE)

    def _transfer_some(self, rendered: np.ndarray, mask: np.ndarray, views: slice) -> np.ndarray:
        targets, images = rows(self.targets, views), pad_views(rendered, self.pyramid.shape)
        for _ in range(self._sweeps):
            images = adjust(self.pyramid, images, targets)
        return match_intensities(images, mask, self._grey[views], self._ranks)


def adjust(pyramid: AnalyticPyramid, images: np.ndarray, targets: Statistics) -> np.ndarray:
    """Project images once onto those with each group of the statistics, from coarse to fine.

    Args:
        pyramid: That of their size.
        images: Shape (view, rows, columns).
        targets: One row a view.
    """
    levels = pyramid.analyze(images)
    coarse = None
    low = _set_low(levels.lows[-1], targets, pyramid.height)
    for scale in reversed(range(pyramid.height)):
        bands = levels.bands[scale]
        beside = (None, None) if coarse is None else parents(pyramid, coarse, scale)
        bands = _set_magnitudes(bands, targets, scale, beside[0])
        wanted = targets.get(("real parent", scale))
        real = moments.set_correlations(bands.real, targets["real", scale], beside[1], wanted)
        coarse = pyramid.analytic(real, scale)
        low = _set_low(pyramid.merge(low, real, scale), targets, scale)
    highpass = moments.set_variance(levels.highpass, targets["highpass", 0])
    return _set_pixels(pyramid.finish(low, highpass), targets["pixel", 0])


def _set_low(low: np.ndarray, targets: Statistics, scale: int) -> np.ndarray:
    """Set autocorrelation, skewness and kurtosis of a low-pass image; its mean stays."""
    mean = low.mean(axis=(-2, -1), keepdims=True)
    low = moments.set_autocorrelation(low - mean, targets["low autocorrelation", scale])
    skewness, kurtosis = np.moveaxis(targets["low moments", scale], -1, 0)
    return moments.set_kurtosis(moments.set_skewness(low, skewness), kurtosis) + mean


def _set_magnitudes(bands: np.ndarray, targets: Statistics, scale: int, beside: np.ndarray | None) -> np.ndarray:
    """Set products and autocorrelations of the magnitudes; phases stay."""
    strength, mean = magnitudes(bands)
    wanted = targets.get(("magnitude parent", scale))
    made = moments.set_correlations(strength, targets["magnitude", scale], beside, wanted)
    made = moments.set_autocorrelation(made, targets["magnitude autocorrelation", scale])
    made = np.maximum(made + targets["magnitude mean", scale][..., None, None], 0)
    before = strength + mean[..., None, None]
    return bands * (made / np.maximum(before, TINY)).astype(before.dtype)


def _set_pixels(images: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Set mean, variance, skewness, kurtosis and range of images."""
    mean, variance, skewness, kurtosis, low, high = (row for row in targets.T)
    apart = moments.set_variance(images - images.mean(axis=(-2, -1), keepdims=True), variance)
    apart = moments.set_kurtosis(moments.set_skewness(apart, skewness), kurtosis)
    bounds = low[:, None, None].astype(images.dtype), high[:, None, None].astype(images.dtype)
    return np.clip(apart + mean[:, None, None].astype(images.dtype), *bounds)

"""Appearance transfer: give rendered views the statistics of the inputs (Section 3.2, Heeger and Bergen 1995).

Every band of a view's steerable pyramid is matched to the mixture of its two neighbouring inputs (Eq. 4); then the
pyramid is collapsed and the intensities are matched. Orthographic views repeat mirrored after 180 degrees, so the
neighbour beyond the last input is the first one flipped.
"""

from collections.abc import Hashable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from warpfluid.kernels.launch import thread_count
from warpfluid.reconstruction.histogram import MIXTURES, match, rank_grid
from warpfluid.reconstruction.neighbours import around, between
from warpfluid.reconstruction.pyramid import default_height, padded_shape, shared_pyramid

INTENSITY = "intensity"
_CHUNK = 6  # views at a time, so that a band is matched while it is in the cache


class AppearanceTransfer:
    """The M-step of a fan of views. The targets depend on the inputs alone and are worked out once.

    Args:
        images: Input images, shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].
        fan_deg: Angles of the views to transfer to, in [0, 180) [degree].
        height: Scales of the pyramid; from the picture's size when omitted.
        interpolation: A key of ``histogram.MIXTURES``, or ``first`` for the first input alone.
    """

    def __init__(
        self,
        images: np.ndarray,
        angles_deg: tuple[float, ...],
        fan_deg: tuple[float, ...],
        *,
        height: int | None = None,
        interpolation: str = "density",
    ):
        self._size = images.shape[1:]
        self.pyramid = shared_pyramid(padded_shape(self._size), height or default_height(self._size))
        if interpolation == "first":
            images, angles_deg, interpolation = images[:1], angles_deg[:1], "nearest"
        self._targets, self._ranks = self._make_targets(images, angles_deg, fan_deg, interpolation)

    def transfer(self, rendered: np.ndarray, mask: np.ndarray) -> np.ndarray:
        """Modify rendered views so that they look like the inputs.

        Args:
            rendered: One view for each angle of the fan, shape (angle, u, v).
            mask: Projection of the visual hull, bool, shape of ``rendered``; outside it the result is 0.

        Returns:
            The modified views, shape of ``rendered``; the same for any number of threads.
        """
        out = np.empty(rendered.shape, np.float32)

        def work(begin: int) -> None:
            views = slice(begin, min(begin + _CHUNK, len(rendered)))
            out[views] = self._transfer_chunk(rendered[views], mask[views], views)

        with ThreadPoolExecutor(thread_count()) as pool:
            list(pool.map(work, range(0, len(rendered), _CHUNK)))
        return out

    def _transfer_chunk(self, rendered: np.ndarray, mask: np.ndarray, views: slice) -> np.ndarray:
        width, rows = self._size

        def matched(key: Hashable, band: np.ndarray) -> np.ndarray:
            flat = np.ascontiguousarray(band, np.float32).reshape(len(band), -1)
            fit = match(flat, self._targets[key][views], self._ranks[key], keep_zero=key == INTENSITY)
            return fit.reshape(band.shape)

        images = self.pyramid.collapse(self.pyramid.build(self._pad(rendered), matched))
        inside = np.zeros(images.shape, bool)
        inside[:, :width, :rows] = mask
        darkest = np.minimum(images.min(axis=(1, 2), keepdims=True), 0)
        images = matched(INTENSITY, np.where(inside, images, darkest)) * inside
        return images[:, :width, :rows]

    def _pad(self, images: np.ndarray) -> np.ndarray:
        padded = np.zeros((len(images), *self.pyramid.shape), np.float32)
        padded[:, : images.shape[1], : images.shape[2]] = images
        return padded

    def _make_targets(self, images, angles_deg, fan_deg, interpolation):
        images, angles = around(images, angles_deg)
        images = self._pad(images)
        left, parts = between(angles, fan_deg)
        bands = self.pyramid.build(images) | {INTENSITY: images}
        targets, ranks = {}, {}
        for key, band in bands.items():
            values = np.sort(band.reshape(len(band), -1), axis=-1)
            ranks[key] = rank_grid(values.shape[1])
            levels = (ranks[key] + 0.5) / values.shape[1]
            name = "quantile" if interpolation == "hybrid" and key != INTENSITY else interpolation
            targets[key] = np.empty((len(left), levels.size), np.float32)
            for pair in np.unique(left):
                at = np.flatnonzero(left == pair)
                targets[key][at] = MIXTURES[name](values[pair], values[pair + 1], parts[at], levels)
        return targets, ranks

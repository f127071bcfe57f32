"""Appearance transfer: give rendered views the statistics of the inputs (Section 3.2, Heeger and Bergen 1995).

Every band of a view's steerable pyramid is matched to the mixture of its two neighbouring inputs (Eq. 4); then the
pyramid is collapsed and the intensities are matched. Orthographic views repeat mirrored after 180 degrees, so the
neighbour beyond the last input is the first one flipped.
"""

from collections.abc import Hashable

import numpy as np

from warpfluid.reconstruction.fan import match_intensities, modify_views, pad_views
from warpfluid.reconstruction.histogram import match, mix_neighbours
from warpfluid.reconstruction.neighbours import around, between
from warpfluid.reconstruction.pyramid import default_height, padded_shape, shared_pyramid

INTENSITY = "intensity"
AT_ONCE = 6  # views at a time, so that a band is matched while it is in the cache


class AppearanceTransfer:
    """The M-step of a fan of views. The targets depend on the inputs alone and are worked out once.

    Args:
        images: Input images, shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].
        fan_deg: Angles of the views to transfer to, in [0, 180) [degree].
        height: Scales of the pyramid; from the picture's size when omitted.
        interpolation: A key of ``histogram.MIXTURES``, or ``first`` for the first input alone.
        part_highpass: Match the finest detail direction by direction. A volume whose slices are fitted one by one has
            no fine detail across and any amount of it along the height. Matched as a whole, what is missing of the
            one is made up for by the other, which shows as combs of level lines.
    """

    def __init__(
        self,
        images: np.ndarray,
        angles_deg: tuple[float, ...],
        fan_deg: tuple[float, ...],
        *,
        height: int | None = None,
        interpolation: str = "density",
        part_highpass: bool = True,
    ):
        size = images.shape[1:]
        height = height or default_height(size)
        self.pyramid = shared_pyramid(padded_shape(size), height, part_highpass=part_highpass)
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
        return modify_views(self._transfer_some, rendered, mask, at_once=AT_ONCE)

    def _transfer_some(self, rendered: np.ndarray, mask: np.ndarray, views: slice) -> np.ndarray:
        def matched(key: Hashable, band: np.ndarray) -> np.ndarray:
            flat = np.ascontiguousarray(band, np.float32).reshape(len(band), -1)
            return match(flat, self._targets[key][views], self._ranks[key], keep_zero=False).reshape(band.shape)

        images = self.pyramid.collapse(self.pyramid.build(pad_views(rendered, self.pyramid.shape), matched))
        return match_intensities(images, mask, self._targets[INTENSITY][views], self._ranks[INTENSITY])

    def _make_targets(self, images, angles_deg, fan_deg, interpolation):
        images, angles = around(images, angles_deg)
        images = pad_views(images, self.pyramid.shape)
        left, parts = between(angles, fan_deg)
        bands = self.pyramid.build(images) | {INTENSITY: images}
        targets, ranks = {}, {}
        for key, band in bands.items():
            name = "quantile" if interpolation == "hybrid" and key != INTENSITY else interpolation
            targets[key], ranks[key] = mix_neighbours(band, left, parts, name)
        return targets, ranks

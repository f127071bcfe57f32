"""Multiplicative balancing: make a volume agree with measured views exactly.

One view after the other, every voxel is multiplied by the mean over its rays of measured / rendered (iterative
proportional fitting). Density stays non-negative and dark places stay dark, and a few sweeps make the input views
exact, which neither a clip after conjugate gradients nor a large weight on the inputs can.
"""

from collections.abc import Iterator

import numpy as np
import warp as wp

from warpfluid.kernels import vectors
from warpfluid.projector import Projector

FLOOR = 1e-3  # grey level under which a rendered pixel counts as dark
CAP = 4.0  # largest correction of one sweep


class Balancing:
    """The measured views that a volume is balanced against.

    Args:
        images: Measured images, shape (view, u, v).
        projectors: A projector for each, of its angle alone, all with the same visual hull.
    """

    def __init__(self, images: np.ndarray, projectors: list[Projector]):
        device = projectors[0].device
        self._views = projectors
        self._images = [wp.array(i[None], dtype=float, device=device) for i in np.ascontiguousarray(images)]
        self._seen = [view.backproject(_ones(view.image_shape, device)) for view in projectors]
        self._factor = wp.empty(projectors[0].shape, dtype=float, device=device)

    @property
    def views(self) -> Iterator[tuple[Projector, wp.array, wp.array]]:
        """For each view its projector, its image, and how often it sees a voxel."""
        return zip(self._views, self._images, self._seen, strict=True)

    def apply(self, volume: wp.array, sweeps: int, *, power: float = 1.0) -> wp.array:
        """Balance a volume in place.

        Args:
            volume: Non-negative, zero outside the hull, shape (x, z, y).
            sweeps: How often each view is visited.
            power: Exponent of the correction, 0 to 1; lower is milder where measured views disagree.

        Returns:
            The volume.
        """
        for _ in range(sweeps):
            for view, image, seen in self.views:
                rendered = view.project(volume)
                vectors.ratio(image, rendered, floor=FLOOR, cap=CAP, power=power, out=rendered)
                view.backproject(rendered, out=self._factor)
                vectors.apply_mean(volume, self._factor, seen)
        return volume


def _ones(shape: tuple[int, ...], device: wp.Device) -> wp.array:
    return wp.full(shape, 1.0, dtype=float, device=device)

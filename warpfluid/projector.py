"""The projector pair: ray casting at a set of angles, and its exact transpose.

Nothing above knows how a view is cast. Today every view is orthographic and turns about the y axis.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import warp as wp

from warpfluid.device import pick_device
from warpfluid.kernels import checks
from warpfluid.kernels.tomography import projection, visual_hull

Array = TypeVar("Array", np.ndarray, wp.array)


class Projector:
    """B of Eq. 1: renders a volume at many angles; ``projector.T`` is its exact transpose.

    Args:
        angles_deg: Angle of every view; t sees voxel (x, z) at u = x cos t + z sin t [degree].
        shape: Shape of the volume (x, z, y).
        hull: 0 outside, 1 or a weight inside, shape (x, z, y). Back-projection is multiplied by it, and rays visit
            only the rows of the volume that it occupies, so a projected volume must be zero outside.
        footprint: ``box`` gives every voxel the same total in every view, ``joseph`` interpolates along rows.
        device: Where to compute; the hull's device, or else the first GPU there is.
        width: Width of the images, and of the box that the views turn about; x's and z's length by default.
        corner: Where in the box the volume begins (x, z), for a volume that is only a part of it.

    Raises:
        ValueError: If shapes, angles or the footprint make no sense.
    """

    def __init__(
        self,
        angles_deg: Sequence[float],
        shape: tuple[int, int, int],
        *,
        hull: wp.array | np.ndarray | None = None,
        footprint: str = "box",
        device: str | wp.Device | None = None,
        width: int | None = None,
        corner: tuple[int, int] = (0, 0),
    ):
        angles = np.asarray(angles_deg, np.float64).reshape(-1)
        if not angles.size or not np.isfinite(angles).all():
            raise ValueError(f"angles_deg is {angles_deg!r}, expected at least one finite angle")
        if len(shape) != 3 or min(shape) < 1 or (width is None and shape[0] != shape[1]):
            raise ValueError(f"shape is {tuple(shape)}, expected (x, z, y) with x and z equally long, or a width")
        if footprint not in projection.FOOTPRINTS:
            raise ValueError(f"footprint is {footprint!r}, expected one of {', '.join(projection.FOOTPRINTS)}")
        self.angles_deg = tuple(float(angle) for angle in angles)
        self.shape = tuple(int(length) for length in shape)
        self.width = int(width or shape[0])
        self.corner = (int(corner[0]), int(corner[1]))
        if any(not 0 <= c <= self.width - n for c, n in zip(self.corner, self.shape[:2], strict=True)):
            raise ValueError(f"corner is {corner}: {tuple(shape)} voxels from there leave the box of {self.width}")
        self.footprint = footprint
        if device is None and isinstance(hull, wp.array):
            device = hull.device
        self.device = pick_device(device)
        self.hull = self._on_device(np.ones(self.shape, np.float32) if hull is None else hull, "hull", self.shape)
        self._directions = directions(angles, self.device)
        self._weights = wp.full(angles.size, 1.0, dtype=float, device=self.device)
        self._occupied = visual_hull.occupied_runs(self.hull)
        self._spans = projection.ray_spans(
            self._directions, self._occupied, self.shape[2], width=self.width, corner=self.corner
        )

    @property
    def image_shape(self) -> tuple[int, int, int]:
        """Shape of the images: (angle, u, v)."""
        return (len(self.angles_deg), self.width, self.shape[2])

    def project(self, volume: Array, *, out: wp.array | None = None) -> Array:
        """Render a volume at every angle.

        Args:
            volume: Shape (x, z, y), zero outside the hull.
            out: Images to write, shape (angle, u, v).

        Returns:
            The ray sums, shape (angle, u, v), of the kind that went in (NumPy or Warp).
        """
        on_device = self._on_device(volume, "volume", self.shape)
        out = wp.empty(self.image_shape, dtype=float, device=self.device) if out is None else out
        projection.project(
            on_device, self._directions, self._spans, footprint=self.footprint, out=out, corner=self.corner
        )
        return out.numpy() if isinstance(volume, np.ndarray) else out

    def backproject(
        self, images: Array, *, weights: Sequence[float] | None = None, out: wp.array | None = None
    ) -> Array:
        """Add up for every voxel of the hull the pixels that see it.

        Args:
            images: Shape (angle, u, v).
            weights: One factor an angle; 1 when omitted.
            out: Volume to write, shape (x, z, y).

        Returns:
            The volume, shape (x, z, y), of the kind that went in (NumPy or Warp).
        """
        on_device = self._on_device(images, "images", self.image_shape)
        out = wp.empty(self.shape, dtype=float, device=self.device) if out is None else out
        factors = self._weights if weights is None else wp.array(weights, dtype=float, device=self.device)
        projection.backproject(
            on_device,
            self._directions,
            factors,
            self.hull,
            self._occupied,
            footprint=self.footprint,
            out=out,
            corner=self.corner,
        )
        return out.numpy() if isinstance(images, np.ndarray) else out

    __call__ = project
    __matmul__ = project

    @property
    def T(self) -> "Transpose":
        """The transpose: ``projector.T @ images`` back-projects."""
        return Transpose(self)

    def _on_device(self, array, name: str, shape: tuple[int, ...]) -> wp.array:
        if not isinstance(array, wp.array):
            array = wp.array(np.ascontiguousarray(array, np.float32), dtype=float, device=self.device)
        checks.floats(3, **{name: array})
        checks.shape(shape, **{name: array})
        return array


class Transpose:
    """The transpose of a projector: images in, volume out."""

    def __init__(self, projector: Projector):
        self.T = projector

    def __matmul__(self, images: Array) -> Array:
        return self.T.backproject(images)

    __call__ = __matmul__


def directions(angles_deg: np.ndarray, device: wp.Device) -> wp.array:
    """Return cos t, sin t, m = max(|cos t|, |sin t|) and 1 / m of every angle; multiples of 90 degrees are exact."""
    radians = np.deg2rad(np.asarray(angles_deg, np.float64))
    c, s = (np.round(part, 15) for part in (np.cos(radians), np.sin(radians)))
    m = np.maximum(np.abs(c), np.abs(s))
    return wp.array(np.stack([c, s, m, 1 / m], axis=1), dtype=wp.vec4, device=device)

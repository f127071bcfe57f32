"""What the EM iteration is given: measured views, how unseen ones should look, the visual hull.

A single view, the commonest case, needs a stand-in for the side. In the paper the front is copied to the side as a
measurement, which makes the volume symmetric. Here the front alone is measured: the mirrored front says how the side
looks, and the hull is a circle a height about the bulk of the light, so that depth does not follow every wisp.
"""

import functools
from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy.ndimage import distance_transform_edt, gaussian_filter1d, grey_opening

from warpfluid.balance import Balancing
from warpfluid.footage.tone import undo_shoulder
from warpfluid.kernels.tomography.visual_hull import silhouette_hull
from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector, directions
from warpfluid.views import Views

BULK_CUT = 0.1  # share of a row's light left out at either end when its bulk is measured
HULL_SMOOTHING = 8.0  # smoothing of the circles over heights [voxel]
HULL_MARGIN = 1.5  # [voxel]
HULL_SOFTNESS = 0.3  # how the round hull's weight falls towards its rim; a hard rim shows as an outline
HULL_RIM = 0.02
CUT_MARGIN = 2  # around the extent of the hull [voxel]


@dataclass(frozen=True)
class Inputs:
    """Views in grey levels of linear light, angles within [0, 180), and the hull they span.

    Attributes:
        images: How the volume looks, measured views first, shape (view, u, v).
        angles_deg: Their angles.
        measured: How many of them are measurements.
        hull: 0 outside, 1 inside or less towards a soft rim, shape (x, z, y), cut to the part of the box it needs.
        corner: Where in the box, which is as wide and deep as the images are wide, that part begins (x, z).
        side: A side view laid over the round hull, which only the start sees; None for several views.
        threshold: Grey level of the silhouette.
        black: Grey level up to which a made pixel is black.
    """

    images: np.ndarray
    angles_deg: tuple[float, ...]
    measured: int
    hull: wp.array
    corner: tuple[int, int]
    side: np.ndarray | None
    threshold: float
    black: float

    @property
    def row_sums(self) -> np.ndarray:
        """Light of every height, the same in all views of an emissive volume, shape (v,)."""
        return self.images[: self.measured].sum(axis=1).mean(axis=0)

    @property
    def fitted(self) -> int:
        """How many of the images a volume is fitted to: all but a stand-in that only tells how the side looks."""
        return len(self.images) if self.side is None else self.measured

    @functools.cached_property
    def support(self) -> wp.array:
        """1 where the hull is not 0."""
        return wp.array((self.hull.numpy() > 0).astype(np.float32), dtype=float, device=self.hull.device)

    @property
    def part(self) -> tuple[slice, slice]:
        """The part of the box that volumes cover, as indices of x and z."""
        return tuple(slice(c, c + n) for c, n in zip(self.corner, self.hull.shape[:2], strict=True))

    @property
    def box(self) -> tuple[int, int, int]:
        """Shape of the whole box (x, z, y)."""
        return (self.images.shape[1], self.images.shape[1], self.images.shape[2])

    def whole(self, volume: wp.array) -> np.ndarray:
        """Return a volume in the whole box, shape (x, z, y)."""
        out = np.zeros(self.box, np.float32)
        out[self.part] = volume.numpy()
        return out

    def projector(self, angles_deg: tuple[float, ...], footprint: str, *, soft: bool = True) -> Projector:
        """Return the projector of some angles inside the hull, with the soft rim that it may have or without."""
        place = {"corner": self.corner, "width": self.images.shape[1]}
        hull = self.hull if soft else self.support
        return Projector(angles_deg, hull.shape, hull=hull, footprint=footprint, **place)

    def balancing(self, footprint: str) -> Balancing:
        """Return the balancing against all measured views."""
        measured = slice(0, self.measured)
        return Balancing(self.images[measured], self.projectors(self.angles_deg[measured], footprint))

    def projectors(self, angles_deg: tuple[float, ...], footprint: str) -> list[Projector]:
        """Return a projector for each angle alone."""
        return [self.projector((angle,), footprint) for angle in angles_deg]


def make_inputs(views: Views, options: ReconstructOptions, device: wp.Device) -> Inputs:
    """Prepare views for reconstruction: scale, tone curve, angles, stand-in for a missing side, hull."""
    scale = np.float32(255 / views.white)
    images = undo_shoulder(views.images * scale, options.shoulder)
    threshold = float(undo_shoulder(np.float64(options.threshold), options.shoulder))
    black = float(undo_shoulder(np.float64(1.0), options.shoulder))
    images, angles = _within_half_turn(images, views.angles_deg)
    measured, side, half_depth = len(angles), None, None
    if len(angles) == 1:
        front, angle = images[0], angles[0]
        look = front if options.stand_in != "mirror" else front[::-1]
        if options.stand_in == "measured":
            measured = 2
        if options.hull != "silhouette":
            centre, radius = _circles(front, options.hull_radius)
            half_depth = _half_depth(front, threshold, centre, radius)
            if options.stand_in != "measured":
                side = _laid_over(look, len(front) - 1 - centre if options.stand_in == "mirror" else centre)
                side *= _ratio(front.sum(0), side.sum(0))
        stand_in, at = _within_half_turn(np.stack([look, look if side is None else side]), (angle + 90,) * 2)
        images, angles = np.stack([front, stand_in[0]]), (angle, at[0])
        side = None if side is None else stand_in[1]
    seen = images if side is None else images[:1]
    hull = _hull(seen, angles[: len(seen)], threshold, half_depth, device)
    corner, hull = _cut(hull)
    hull = wp.array(hull, dtype=float, device=device)
    return Inputs(np.ascontiguousarray(images, np.float32), angles, measured, hull, corner, side, threshold, black)


def given_statistics(
    statistics: Views, views: Views, options: ReconstructOptions
) -> tuple[np.ndarray, tuple[float, ...]]:
    """Return how views look that others than the inputs tell: images in grey levels of linear light, and their angles.

    Raises:
        ValueError: If the images have another size than the inputs.
    """
    size, wanted = statistics.images.shape[1:], views.images.shape[1:]
    if size != wanted:
        raise ValueError(f"statistics have images of {size[0]} x {size[1]} pixels, expected {wanted[0]} x {wanted[1]}")
    images = undo_shoulder(statistics.images * np.float32(255 / statistics.white), options.shoulder)
    images, angles = _within_half_turn(images, statistics.angles_deg)
    return np.asarray(images, np.float32), angles


def _within_half_turn(images: np.ndarray, angles_deg: tuple[float, ...]) -> tuple[np.ndarray, tuple[float, ...]]:
    """Bring angles into [0, 180); an odd number of half turns mirrors a view."""
    turns = np.floor(np.round(np.asarray(angles_deg, np.float64), 9) / 180).astype(int)
    images = np.stack([image[::-1] if turn % 2 else image for image, turn in zip(images, turns, strict=True)])
    return images, tuple(max(float(a - 180 * turn), 0.0) for a, turn in zip(angles_deg, turns, strict=True))


def _hull(images, angles_deg, threshold, half_depth, device) -> np.ndarray:
    lit = wp.array((images > threshold).astype(np.uint8), dtype=wp.uint8, device=device)
    hull = silhouette_hull(lit, directions(np.asarray(angles_deg), device)).numpy()
    if half_depth is None:
        return hull
    n = len(half_depth)
    x, z = np.meshgrid(np.arange(n) - (n - 1) / 2, np.arange(n) - (n - 1) / 2, indexing="ij")
    angle = np.deg2rad(angles_deg[0])
    across = np.clip(np.rint(x * np.cos(angle) + z * np.sin(angle) + (n - 1) / 2).astype(int), 0, n - 1)
    depth = np.abs(z * np.cos(angle) - x * np.sin(angle))
    share = depth[..., None] / np.maximum(half_depth[across], 1)
    weight = np.maximum(1 - share**2, HULL_RIM) ** HULL_SOFTNESS
    return (hull * weight * (share <= 1 + 1e-6)).astype(np.float32)


def _cut(hull: np.ndarray) -> tuple[tuple[int, int], np.ndarray]:
    """Cut a hull to its extent in x and z, with a margin for the blur; return where it begins, and the part."""
    occupied = hull.any(axis=2)
    ranges = []
    for axis in (1, 0):
        lit = np.flatnonzero(occupied.any(axis=axis))
        low, high = (lit[0], lit[-1] + 1) if lit.size else (0, 1)
        ranges.append((max(int(low) - CUT_MARGIN, 0), min(int(high) + CUT_MARGIN, len(hull))))
    (x0, x1), (z0, z1) = ranges
    return (x0, z0), np.ascontiguousarray(hull[x0:x1, z0:z1])


def _circles(front: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Centre and radius of a circle a height about the bulk of its light, smoothed over heights [voxel]."""
    total = front.sum(0)
    part = np.cumsum(front, axis=0) / np.maximum(total, 1e-6)
    left, right = (part < BULK_CUT).sum(0), (part < 1 - BULK_CUT).sum(0)
    weight = (total > 1e-3) + 1e-6

    def smooth(values):
        return gaussian_filter1d(values * weight, HULL_SMOOTHING) / gaussian_filter1d(weight, HULL_SMOOTHING)

    half = np.maximum(smooth((right - left) / 2 + 0.5), 1)
    return smooth((left + right) / 2), half * reach + HULL_MARGIN


def _half_depth(front: np.ndarray, threshold: float, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """How deep the hull reaches at each pixel, before and behind the middle, shape (u, v) [voxel].

    A run of lit pixels that leaves the circle gets a disc of its own, where such runs persist over heights; a spark, or
    the few rows in which one touches the flame, is only as deep as it is thick in the picture.
    """
    lit = front > threshold
    u = np.arange(len(front))[:, None]
    circle = np.sqrt(np.maximum(radius**2 - (u - centre) ** 2, 0))
    discs = np.zeros(front.shape)
    for y in range(front.shape[1]):
        edges = np.flatnonzero(np.diff(np.pad(lit[:, y].astype(np.int8), 1)))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            if a > centre[y] - radius[y] and b - 1 < centre[y] + radius[y]:
                continue
            flat = min(1, radius[y] / ((b - a) / 2))
            own = ((b - a) / 2 * flat + 1) ** 2 - ((u[a:b, 0] - (a + b - 1) / 2) * flat) ** 2
            discs[a:b, y] = np.sqrt(np.maximum(own, 1))
    persistent = gaussian_filter1d(grey_opening(discs, (1, int(2 * HULL_SMOOTHING) + 1)), HULL_SMOOTHING / 4)
    thickness = np.minimum(distance_transform_edt(lit), radius)
    return np.maximum.reduce([circle, persistent, thickness])


def _laid_over(picture: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Shift every row of a side view so that its bulk lies in the middle, where the circles are."""
    n = len(picture)
    at = np.arange(n) - (n - 1) / 2
    rows = [np.interp(centre[y] + at, np.arange(n), row, left=0, right=0) for y, row in enumerate(picture.T)]
    return np.stack(rows, axis=1).astype(np.float32)


def _ratio(wanted: np.ndarray, found: np.ndarray) -> np.ndarray:
    return np.where(found > 1e-3, wanted / np.maximum(found, 1e-3), 0).astype(np.float32)

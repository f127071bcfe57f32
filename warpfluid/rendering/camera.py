"""Cameras, in the index coordinates of a volume: (x, y, z) in voxels, y up.

At t degrees the level camera sees the point (x, z) at u = x cos t + z sin t, as the projector does: 0 is the front,
where the camera stands at the greatest z and looks along -z, and 90 is the left of it, looking along x.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MARGIN = 2.0  # an orthographic camera stands so many voxels outside the sphere around the box


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        size: Width and height of the picture [pixel].
        eye: Where the camera is (x, y, z) [voxel]; nothing behind it is seen.
        right: Unit vector to the right of the picture (x, y, z).
        up: Unit vector to its top.
        forward: Unit vector into it.
        pixel: Width of a pixel [voxel]; for a perspective camera at distance 1.
        perspective: Whether rays meet in the eye; otherwise they are parallel.
        shift: How far the picture's middle lies off the line of sight, right and up [pixel].
    """

    size: tuple[int, int]
    eye: np.ndarray
    right: np.ndarray
    up: np.ndarray
    forward: np.ndarray
    pixel: float
    perspective: bool
    shift: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        _check_size(self.size)
        if not (np.isfinite(self.pixel) and self.pixel > 0):
            raise ValueError(f"pixel is {self.pixel}, expected a positive width")
        for name in ("eye", "right", "up", "forward"):
            vector = np.asarray(getattr(self, name), np.float64)
            if vector.shape != (3,) or not np.isfinite(vector).all():
                raise ValueError(f"{name} is {vector}, expected three finite numbers (x, y, z)")
            object.__setattr__(self, name, vector)
        object.__setattr__(self, "size", (int(self.size[0]), int(self.size[1])))

    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Return where the rays of the pixels' middles begin and where they go, the top row first.

        Returns:
            Origins and directions (x, y, z), float64, shape (rows, columns, 3) each. A direction's part along
            ``forward`` is 1, so ``origin + depth * direction`` lies at that depth.
        """
        width, height = self.size
        u = (np.arange(width) - 0.5 * (width - 1) + self.shift[0]) * self.pixel
        v = (0.5 * (height - 1) - np.arange(height) + self.shift[1]) * self.pixel
        across = u[None, :, None] * self.right + v[:, None, None] * self.up
        if self.perspective:
            return np.broadcast_to(self.eye, across.shape), self.forward + across
        return self.eye + across, np.broadcast_to(self.forward, across.shape)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return where points (x, y, z) are seen: column, row and depth along forward, shape (n, 3).

        Whole numbers are the middles of pixels. What lies in or behind a perspective camera's eye is seen at infinity.
        """
        away = np.atleast_2d(points) - self.eye
        depth = away @ self.forward
        scale = self.pixel * (np.where(depth > 0, depth, np.nan) if self.perspective else 1.0)
        width, height = self.size
        column = away @ self.right / scale + 0.5 * (width - 1) - self.shift[0]
        row = 0.5 * (height - 1) + self.shift[1] - away @ self.up / scale
        return np.nan_to_num(np.stack([column, row, depth], axis=-1), nan=np.inf)


def orthographic(
    shape: Sequence[int],
    angle_deg: float = 0.0,
    elevation_deg: float = 0.0,
    *,
    size: tuple[int, int] | None = None,
    zoom: float = 1.0,
    target: Sequence[float] | None = None,
) -> Camera:
    """Return a camera with parallel rays; by default that of the projector, a pixel a voxel.

    Args:
        shape: Of the volume (x, z, y).
        angle_deg: Where the camera stands; 0 is the front, 90 the left of it.
        elevation_deg: How far it looks down, -90 to 90.
        size: Width and height of the picture; a pixel a voxel of the level view by default. The level view of the box
            fits into it.
        zoom: Enlarges what is in the middle.
        target: Point in the middle of the picture (x, y, z) [voxel]; the box's middle by default.
    """
    _check_shape(shape)
    if not (np.isfinite(zoom) and zoom > 0):
        raise ValueError(f"zoom is {zoom}, expected a positive number")
    wide, high = max(shape[0], shape[1]), shape[2]
    size = (wide, high) if size is None else tuple(size)
    _check_size(size)
    target = middle(shape) if target is None else np.asarray(target, np.float64)
    right, up, forward = _axes(angle_deg, elevation_deg)
    reach = 0.5 * float(np.linalg.norm(shape)) + float(np.linalg.norm(target - middle(shape))) + MARGIN
    pixel = max(wide / size[0], high / size[1]) / zoom
    return Camera(
        size=size, eye=target - reach * forward, right=right, up=up, forward=forward, pixel=pixel, perspective=False
    )


def perspective(
    shape: Sequence[int],
    angle_deg: float = 0.0,
    elevation_deg: float = 0.0,
    *,
    distance: float,
    field_of_view_deg: float,
    size: tuple[int, int] | None = None,
    target: Sequence[float] | None = None,
) -> Camera:
    """Return a camera whose rays meet in its eye.

    Args:
        shape: Of the volume (x, z, y).
        angle_deg: Where the camera stands; 0 is the front, 90 the left of it.
        elevation_deg: How far it looks down, -90 to 90.
        distance: From the eye to the target [voxel].
        field_of_view_deg: Angle between the top and the bottom of the picture, above 0 and below 180.
        size: Width and height of the picture [pixel]; that of the level view of the box by default.
        target: Point in the middle of the picture (x, y, z) [voxel]; the box's middle by default.
    """
    _check_shape(shape)
    if not (np.isfinite(distance) and distance > 0):
        raise ValueError(f"distance is {distance}, expected a positive number of voxels")
    size = (max(shape[0], shape[1]), shape[2]) if size is None else tuple(size)
    _check_size(size)
    target = middle(shape) if target is None else np.asarray(target, np.float64)
    right, up, forward = _axes(angle_deg, elevation_deg)
    return Camera(
        size=size,
        eye=target - distance * forward,
        right=right,
        up=up,
        forward=forward,
        pixel=_pixel(field_of_view_deg, size),
        perspective=True,
    )


def middle(shape: Sequence[int]) -> np.ndarray:
    """Return the middle (x, y, z) of a volume of shape (x, z, y)."""
    return 0.5 * (np.array([shape[0], shape[2], shape[1]], np.float64) - 1)


def _axes(angle_deg: float, elevation_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return right, up and forward; multiples of 90 degrees are exact."""
    if not math.isfinite(angle_deg):
        raise ValueError(f"angle_deg is {angle_deg}, expected a finite number")
    if not -90 <= elevation_deg <= 90:
        raise ValueError(f"elevation_deg is {elevation_deg}, expected -90 to 90")
    t, e = math.radians(angle_deg), math.radians(elevation_deg)
    c, s, ce, se = (round(part, 15) for part in (math.cos(t), math.sin(t), math.cos(e), math.sin(e)))
    right = np.array([c, 0.0, s])
    forward = np.array([s * ce, -se, -c * ce])
    return right, np.array([s * se, ce, -c * se]), forward


def _pixel(field_of_view_deg: float, size: tuple[int, int]) -> float:
    _check_size(size)
    if not 0 < field_of_view_deg < 180:
        raise ValueError(f"field_of_view_deg is {field_of_view_deg}, expected a number between 0 and 180")
    return 2 * math.tan(math.radians(field_of_view_deg) / 2) / size[1]


def _check_size(size: Sequence[int]) -> None:
    if len(size) != 2 or min(size) < 1:
        raise ValueError(f"size is {tuple(size)}, expected a width and a height of at least 1 pixel")


def _check_shape(shape: Sequence[int]) -> None:
    if len(shape) != 3 or min(shape) < 1:
        raise ValueError(f"shape is {tuple(shape)}, expected (x, z, y)")

"""Rigid bodies in the pictures of a volume: light in front of a body adds to its surface, light behind it is hidden.

The camera is the turntable's: orthographic, level, at t degrees it sees the point (x, z) at u = x cos t + z sin t.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.turntable import _checked, _enlarge, _project

FINE = 2  # samples a pixel and axis, so that edges are smooth
KEY_LIGHT = np.array([-0.45, 0.75, 0.5])  # to the light, from a camera's left, above and in front
AMBIENT = 0.35
HALF_PIXEL = np.array([0.5, 0.5, 0.0])  # from the middle of a pixel to its corner
NOTHING = -np.inf


class DrawnBody(NamedTuple):
    """A surface of flat triangles.

    Attributes:
        vertices: Index coordinates (x, y, z) [voxel], shape (n, 3).
        triangles: Indices, anticlockwise seen from outside, shape (m, 3).
        color: Red, green and blue of a fully lit surface, 0 to 1.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    color: tuple[float, float, float] = (0.55, 0.56, 0.58)


class Layer(NamedTuple):
    """What a camera sees of bodies; the top row first.

    Attributes:
        color: Light of their surfaces, 0 to 1, times the cover, shape (rows, columns, 3).
        cover: Share of each pixel that they cover, shape (rows, columns).
        depth: How far towards the camera from the box's middle [voxel], minus infinity where there is none.
    """

    color: np.ndarray
    cover: np.ndarray
    depth: np.ndarray


def render_with_bodies(
    volume, bodies: Sequence[DrawnBody], angle_deg: float, ramp: str = "fire", *, white: float = 255.0
) -> np.ndarray:
    """Render a volume from one angle, with bodies in it.

    Args:
        volume: Density, NumPy or Warp, shape (x, z, y), as wide as deep.
        bodies: What stands in it.
        angle_deg: Where the camera stands; 0 is the front.
        ramp: Name of a colour ramp.
        white: Ray sum that is the brightest colour.

    Returns:
        The picture, uint8, shape (rows, columns, 3): that of ``render_turntable`` wherever there is no body.

    Raises:
        ValueError: If the volume is not 3D, or the ramp is not known.
    """
    volume = _checked(volume)
    light = _enlarge(_project(volume, [angle_deg]))[0]
    layer = rasterize(bodies, angle_deg, volume.shape, light.shape[1] // volume.shape[0])
    return compose(light, layer, light * share_in_front(volume, layer.depth, angle_deg), ramp, white)


def draw_bodies(
    picture: np.ndarray, bodies: Sequence[DrawnBody], angle_deg: float, shape: tuple[int, int, int]
) -> np.ndarray:
    """Draw bodies over a finished picture, as if all its light were behind them.

    Args:
        picture: uint8, shape (rows, columns, 3), a whole number of pixels a voxel.
        bodies: What is drawn.
        angle_deg: Where the picture's camera stands.
        shape: Of the volume (x, z, y).

    Returns:
        The picture, uint8, of the same shape.

    Raises:
        ValueError: If the picture does not fit the volume.
    """
    scale = picture.shape[1] // shape[0]
    if picture.shape != (shape[2] * scale, shape[0] * scale, 3):
        raise ValueError(f"picture has shape {picture.shape}, which is no multiple of a volume of {tuple(shape)}")
    layer = rasterize(bodies, angle_deg, shape, scale)
    mixed = layer.color * 255 + picture * (1 - layer.cover[..., None])
    return np.rint(np.clip(mixed, 0, 255)).astype(np.uint8)


def compose(light: np.ndarray, layer: Layer, in_front: np.ndarray, ramp: str, white: float) -> np.ndarray:
    """Colour light and lay bodies into it.

    Args:
        light: Ray sums, shape (rows, columns).
        layer: The bodies.
        in_front: Ray sums from the bodies to the camera.
        ramp: Name of a colour ramp.
        white: Ray sum that is the brightest colour.

    Returns:
        The picture, uint8, shape (rows, columns, 3).
    """
    open_air, before = apply_ramp(np.stack([light, in_front]), ramp, white)
    cover = layer.cover[..., None]
    mixed = open_air * (1 - cover) + before * cover + 255 * layer.color
    return np.rint(np.clip(mixed, 0, 255)).astype(np.uint8)


def rasterize(bodies: Sequence[DrawnBody], angle_deg: float, shape: tuple[int, int, int], scale: int = 1) -> Layer:
    """Draw bodies with a depth buffer and Lambert's cosine.

    Args:
        bodies: What is drawn.
        angle_deg: Where the camera stands.
        shape: Of the volume (x, z, y); the picture is as wide as its x.
        scale: Pixels a voxel.
    """
    fine = FINE * scale
    rows, columns = shape[2] * fine, shape[0] * fine
    color, depth = np.zeros((rows, columns, 3)), np.full((rows, columns), NOTHING)
    key = KEY_LIGHT / np.linalg.norm(KEY_LIGHT)
    for body in bodies:
        seen = _seen(np.asarray(body.vertices, np.float64), angle_deg, shape)[body.triangles]
        normals = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        lit = normals @ key / np.maximum(np.linalg.norm(normals, axis=1), 1e-12)
        brightness = AMBIENT + (1 - AMBIENT) * np.maximum(lit, 0)
        corners = (seen + HALF_PIXEL) * [fine, fine, 1] - HALF_PIXEL
        for i in np.flatnonzero(normals[:, 2] > 0):
            _fill(corners[i], brightness[i] * np.asarray(body.color), color, depth)
    blocks = (rows // FINE, FINE, columns // FINE, FINE)
    color, depth = color[::-1].reshape(*blocks, 3), depth[::-1].reshape(blocks)
    return Layer(color.mean(axis=(1, 3)), (depth > NOTHING).mean(axis=(1, 3)), depth.max(axis=(1, 3)))


def share_in_front(volume: np.ndarray, depth: np.ndarray, angle_deg: float) -> np.ndarray:
    """Return what share of every ray's light lies between a depth and the camera.

    Both sums take linear samples a voxel apart along the ray, so their ratio fits the projector's exact sum.

    Args:
        volume: Shape (x, z, y).
        depth: Where bodies are, as in a layer, a whole number of pixels a voxel.
        angle_deg: Where the camera stands.

    Returns:
        Shares from 0 to 1, the shape of ``depth``; 1 where there is no body.
    """
    from scipy.ndimage import map_coordinates

    shares = np.ones(depth.shape)
    rows, columns = np.nonzero(depth > NOTHING)
    if not rows.size:
        return shares
    scale = depth.shape[1] / volume.shape[0]
    u = (columns + 0.5) / scale - 0.5 - 0.5 * (volume.shape[0] - 1)
    v = (depth.shape[0] - rows - 0.5) / scale - 0.5
    reach = int(np.ceil(np.hypot(*volume.shape[:2]) / 2 + np.abs(depth[rows, columns]).max())) + 1
    steps = np.arange(-reach, reach) + 0.5  # from the body's surface, so that a sample is on one side of it
    w = depth[rows, columns][:, None] + steps
    t = np.deg2rad(angle_deg)
    x = u[:, None] * np.cos(t) - w * np.sin(t) + 0.5 * (volume.shape[0] - 1)
    z = u[:, None] * np.sin(t) + w * np.cos(t) + 0.5 * (volume.shape[1] - 1)
    y = np.broadcast_to(np.clip(v, 0, volume.shape[2] - 1)[:, None], x.shape)
    samples = map_coordinates(volume, [x, z, y], order=1, mode="constant")
    total, front = samples.sum(axis=1), samples[:, steps > 0].sum(axis=1)
    shares[rows, columns] = np.where(total > 0, front / np.maximum(total, 1e-30), 0)
    return np.clip(shares, 0, 1)


def _seen(vertices: np.ndarray, angle_deg: float, shape: tuple[int, int, int]) -> np.ndarray:
    """Return points as a camera sees them: u and v [voxel], and how far towards it from the middle."""
    t = np.deg2rad(angle_deg)
    x, y, z = vertices.T - [[0.5 * (shape[0] - 1)], [0.0], [0.5 * (shape[1] - 1)]]
    u = x * np.cos(t) + z * np.sin(t) + 0.5 * (shape[0] - 1)
    return np.stack([u, y, z * np.cos(t) - x * np.sin(t)], axis=1)


def _fill(corners: np.ndarray, light: np.ndarray, color: np.ndarray, depth: np.ndarray) -> None:
    """Fill one triangle where it is nearest, in place; rows count upwards."""
    low = np.maximum(np.ceil(corners[:, :2].min(axis=0)), 0).astype(int)
    high = np.minimum(np.floor(corners[:, :2].max(axis=0)) + 1, depth.shape[::-1]).astype(int)
    if (high <= low).any():
        return
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
    x, y = np.arange(low[0], high[0]), np.arange(low[1], high[1])[:, None]
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    b = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
    c = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
    here = az + b * (bz - az) + c * (cz - az)
    window = (slice(low[1], high[1]), slice(low[0], high[0]))
    nearer = (b >= 0) & (c >= 0) & (b + c <= 1) & (here > depth[window])
    depth[window][nearer] = here[nearer]
    color[window][nearer] = light

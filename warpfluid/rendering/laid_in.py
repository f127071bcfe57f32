"""Solid things in a turntable's pictures: light in front of a body adds to its surface, light behind it is hidden."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import warp as wp

from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.harmonics import uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Medium
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.surfaces import Surface, see

KEY_LIGHT = np.array([-0.45, 0.75, 0.5])  # to the light, from a camera's left, above and in front
AMBIENT = 0.35  # of a surface's brightness; the rest is the key light's


def lay_in(
    light: np.ndarray, volume: np.ndarray, surfaces: Sequence[Surface], angle_deg: float, ramp: str, white: float
) -> np.ndarray:
    """Colour ray sums and lay bodies into them.

    Args:
        light: Ray sums of the volume at an angle, the top row first, any number of pixels a voxel.
        volume: Density, shape (x, z, y).
        surfaces: Bodies.
        angle_deg: Where the camera stands.
        ramp: Name of a colour ramp.
        white: Ray sum that is the brightest colour.

    Returns:
        The picture, uint8, shape (rows, columns, 3).
    """
    camera = orthographic(volume.shape, angle_deg, size=light.shape[::-1])
    camera = replace(camera, pixel=volume.shape[2] / light.shape[0])
    axes = np.stack([camera.right, camera.up, -camera.forward])
    key = Sun(KEY_LIGHT @ axes, np.full(3, np.pi * (1 - AMBIENT)))
    seen = see(surfaces, camera, Lighting((key,), uniform((AMBIENT,) * 3)), device="cpu")
    medium = Medium(fields={"density": wp.array(volume, dtype=float, device="cpu")})
    front, whole = (
        march(medium, camera, limits=np.where(seen.cover > 0, limit, 0)).density for limit in (seen.depth, np.inf)
    )
    share = np.clip(front / np.maximum(whole, 1e-20), 0, 1)  # of light that is in front: the rays' own sums are exact
    open_air, before = apply_ramp(np.stack([light, light * share]), ramp, white)
    cover = seen.cover[..., None]
    mixed = open_air * (1 - cover) + before * cover + 255 * seen.color
    return np.rint(np.clip(mixed, 0, 255)).astype(np.uint8)

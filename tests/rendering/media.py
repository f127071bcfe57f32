"""Puffs, cameras around them, and a slow march by SciPy that the ray marcher is compared with."""

import numpy as np
import warp as wp
from scipy import ndimage

from warpfluid.rendering.camera import middle, orthographic, perspective

LINE = np.array([0.0, 1.0])
ONE = np.ones(2)
VIEWS = {
    "level": lambda shape: orthographic(shape, 35, size=(40, 30)),
    "above": lambda shape: orthographic(shape, -20, 50, size=(30, 40), zoom=1.5),
    "top": lambda shape: orthographic(shape, 10, 90, size=(24, 24)),
    "far": lambda shape: perspective(shape, 130, 20, distance=80, field_of_view_deg=35, size=(40, 30)),
    "inside": lambda shape: perspective(shape, 20, 5, distance=3, field_of_view_deg=90, size=(40, 30)),
}


def on(device, volume):
    return wp.array(np.ascontiguousarray(volume, np.float32), dtype=float, device=device)


def noise(shape, seed=0, sigma=1.5):
    """Smooth puffs with empty space between them, at most 1."""
    found = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(shape), sigma, mode="constant")
    found = np.maximum(found, 0)
    return (found / found.max()).astype(np.float32)


def fine(volume, camera, extinction, emission, steps=16, albedo=0.0, light=1.0):
    """March in equal small steps of the same field: (color, alpha), for one channel.

    Where the marcher reads between planes, so does this; 16 samples a plane.
    """
    origins, directions = camera.rays()
    length = np.linalg.norm(directions, axis=-1)
    reach = 2 * np.linalg.norm(volume.shape) + np.linalg.norm(camera.eye - middle(volume.shape))
    pace = np.abs(directions).max(axis=-1).min()
    depths = (np.arange(0, reach * pace * steps) + 0.5) / (steps * pace)
    padded = np.pad(volume, 1)
    color, open_ = np.zeros(length.shape), np.ones(length.shape)
    for depth in depths:
        x, y, z = np.moveaxis(origins + depth * directions, -1, 0)
        inside = (np.abs(x - 0.5 * (volume.shape[0] - 1)) < volume.shape[0]) & (y > -1) & (y < volume.shape[2])
        if not inside.any():
            continue
        field = ndimage.map_coordinates(padded, [x + 1, z + 1, y + 1], order=1, mode="constant")
        h = length / (steps * pace)
        lost = extinction(field)
        kept = np.exp(-lost * h)
        share = np.where(lost * h > 1e-9, (1 - kept) / np.maximum(lost, 1e-30), h)
        color += open_ * share * (emission(field) + lost * albedo * light)
        open_ *= kept
    return color, 1 - open_

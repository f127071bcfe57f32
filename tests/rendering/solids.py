"""A box of voxels, things that stand in it, and cameras around it."""

import numpy as np
import warp as wp

from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.harmonics import uniform
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.surfaces import Surface
from warpfluid.simulation.triangles import box_surface, turned_surface

SHAPE = (32, 32, 24)
MIDDLE = np.array([15.5, 11.5, 15.5])
FURNACE = Lighting((), uniform((1, 1, 1)))
ABOVE = (0.0, 1.0, 0.0)


def box(size, centre, color=(1.0, 1.0, 1.0)):
    vertices, triangles = box_surface(np.asarray(size))
    return Surface(vertices + np.asarray(centre), triangles, color)


def ball(radius, centre, color=(1.0, 1.0, 1.0), rings=60):
    angles = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    vertices, triangles = turned_surface(radius * np.cos(angles), radius * np.sin(angles), (-radius, radius), 120)
    return Surface(vertices + np.asarray(centre), triangles, color)


def camera_at(angle, scale=4, elevation=0.0):
    return orthographic(SHAPE, angle, elevation, size=(SHAPE[0] * scale, SHAPE[2] * scale))


def smoke(density, extinction=1.0, albedo=0.8, emission=None):
    field = np.broadcast_to(np.asarray(density, np.float32), SHAPE)
    return Medium(
        fields={"density": wp.array(field, dtype=float)},
        extinction=Curve("density", 1.0, [0, extinction]),
        albedo=Curve("density", 1.0, [albedo]),
        emission=Curve("density", 1.0, emission) if emission else None,
    )


def centroid(image):
    """Column and row of the centre of light."""
    rows, columns = np.indices(image.shape)
    return np.array([(columns * image).sum(), (rows * image).sum()]) / image.sum()

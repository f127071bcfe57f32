"""Velocities on the faces of a MAC grid, and what NumPy makes of them, for the tests of forces."""

import numpy as np
import warp as wp

from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP

ALL_OPEN = (OPEN,) * 6
ALL_CLOSED = (CLOSED,) * 6
ALL_WRAP = (WRAP,) * 6
MIXED = (OPEN, CLOSED, WRAP, WRAP, CLOSED, OPEN)
SIDES = [ALL_OPEN, ALL_CLOSED, ALL_WRAP, MIXED]
SHAPE = (9, 7, 53)


def six(sides):
    """The sides as kernels take them."""
    return SIX(*sides)


def wraps(sides, axis):
    """Whether the box wraps along an axis."""
    return sides[2 * axis] == WRAP


def random_faces(shape=SHAPE, sides=ALL_OPEN, seed=0):
    """Velocities that obey the sides: none through walls, the same on both ends of a wrapped axis."""
    rng = np.random.default_rng(seed)
    faces = []
    for axis in range(3):
        face = rng.standard_normal([n + (k == axis) for k, n in enumerate(shape)]).astype(np.float32)
        first, last = np.moveaxis(face, axis, 0)[[0, -1]], np.moveaxis(face, axis, 0)
        if wraps(sides, axis):
            last[-1] = first[0]
        for end in (0, -1):
            if sides[2 * axis - end] == CLOSED:
                last[end] = 0
        faces.append(face)
    return faces


def still(shape=SHAPE):
    """Velocities of a fluid at rest."""
    return [np.zeros([n + (k == axis) for k, n in enumerate(shape)], np.float32) for axis in range(3)]


def on(device, arrays):
    """Copy arrays to a device, under the launchers' names."""
    names = ("velocity_x", "velocity_z", "velocity_y")
    return {name: wp.array(array, dtype=float, device=device) for name, array in zip(names, arrays, strict=True)}


def pushed(launcher, faces, device, **others):
    """What a launcher makes of velocities."""
    arrays = on(device, faces)
    launcher(**arrays, **others)
    return [array.numpy() for array in arrays.values()]


def face_means(cells, sides):
    """The mean of both voxels of every face, 0 outside, three arrays."""
    means = []
    for axis in range(3):
        padding = [(int(k == axis),) * 2 for k in range(3)]
        padded = np.pad(cells.astype(np.float64), padding, mode="wrap" if wraps(sides, axis) else "constant")
        padded = np.moveaxis(padded, axis, 0)
        means.append(np.moveaxis((padded[1:] + padded[:-1]) / 2, 0, axis))
    return means


def without_walls(changes, sides):
    """Changes that are none on faces of closed sides."""
    for axis, change in enumerate(changes):
        for end in (0, -1):
            if sides[2 * axis - end] == CLOSED:
                np.moveaxis(change, axis, 0)[end] = 0
    return changes


def places(shape=SHAPE):
    """Index coordinates of the faces' middles: for each axis an array (..., 3)."""
    return [
        np.stack(
            np.meshgrid(*(np.arange(n + (k == axis)) - (k == axis) / 2 for k, n in enumerate(shape)), indexing="ij"), -1
        )
        for axis in range(3)
    ]

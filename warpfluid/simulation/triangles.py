"""Closed surfaces of triangles: are they closed, how much do they hold, how hard are they to turn."""

from typing import NamedTuple

import numpy as np


class Mass(NamedTuple):
    """What a solid of mass density 1 weighs.

    Attributes:
        volume: Its volume, and so its mass.
        centre: Its centre of mass, shape (3,).
        inertia: Its inertia about that centre, shape (3, 3).
    """

    volume: float
    centre: np.ndarray
    inertia: np.ndarray


def check_closed(vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Check that triangles close a space: every edge belongs to two of them, once in each direction.

    Raises:
        ValueError: If there are holes, or triangles face the wrong way.
    """
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"vertices are {vertices.shape} and triangles {triangles.shape}, expected (n, 3) and (m, 3)")
    if len(triangles) < 4 or not np.isfinite(vertices).all():
        raise ValueError("the mesh has fewer than four triangles, or vertices that are not finite")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError(f"triangles name vertices {triangles.min()} to {triangles.max()}, of {len(vertices)}")
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    _, triangles_at = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if wrong := np.count_nonzero(triangles_at != 2):
        raise ValueError(
            f"the mesh is not closed: {wrong} of its edges have not one triangle on each side; fill its holes"
        )
    if len(np.unique(edges, axis=0)) < len(edges):
        raise ValueError("triangles of the mesh face different ways: make its normals agree")


def weigh(vertices: np.ndarray, triangles: np.ndarray) -> Mass:
    """Weigh a closed mesh as a sum of tetrahedra between its triangles and the origin (Mirtich 1996).

    Args:
        vertices: Shape (n, 3).
        triangles: Indices, anticlockwise seen from outside, shape (m, 3).

    Returns:
        The mass; the volume is negative if the triangles are clockwise.

    Raises:
        ValueError: If the mesh holds nothing.
    """
    corners = np.asarray(vertices, np.float64)[triangles]
    sixths = np.linalg.det(corners)
    volume = sixths.sum() / 6
    if abs(volume) < 1e-12 * max(np.ptp(corners.reshape(-1, 3), axis=0).max(), 1e-12) ** 3:
        raise ValueError("the mesh holds no volume")
    total = corners.sum(axis=1)
    centre = np.einsum("t,ti->i", sixths, total) / (24 * volume)
    second = np.einsum("t,tci,tcj->ij", sixths, corners, corners) + np.einsum("t,ti,tj->ij", sixths, total, total)
    spread = second / 120 - volume * np.outer(centre, centre)
    return Mass(float(volume), centre, np.trace(spread) * np.eye(3) - spread)


def cover(vertices: np.ndarray, triangles: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cover a surface with points of nearly equal area, by halving the longest edges.

    Args:
        vertices: Shape (n, 3).
        triangles: Shape (m, 3).
        count: About how many points; a mesh of more triangles gets one each.

    Returns:
        Points (p, 3), outward normals (p, 3) and shares of the surface (p,), which sum to 1.
    """
    corners = np.asarray(vertices, np.float64)[triangles]
    limit = 1.5 * _areas(corners).sum() / count
    while (wide := _areas(corners) > limit).any():
        corners = np.concatenate([corners[~wide], _halves(corners[wide])])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    keep = length > 0
    normals = normals[keep] / length[keep, None]
    return corners[keep].mean(axis=1), normals, length[keep] / length.sum()


def box_surface(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eight vertices and twelve triangles of a box around the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [half for a, b, c, d in sides for half in ((a, b, c), (a, c, d))]
    return corners * np.asarray(size), np.array(triangles, np.int32)


def turned_surface(
    radii: np.ndarray, heights: np.ndarray, ends: tuple[float, float], around: int = 64
) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and triangles of an outline turned about y.

    Args:
        radii: Of its rings, from the lowest to the highest, shape (r,).
        heights: Of the rings, shape (r,).
        ends: Heights of the axis' lowest and highest point.
        around: Vertices of a ring.
    """
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.zeros(around), np.sin(turn)], axis=1)
    rings = radii[:, None, None] * ring + np.multiply.outer(heights, [0.0, 1.0, 0.0])[:, None]
    poles = np.multiply.outer(ends, [0.0, 1.0, 0.0])
    low, high, here = len(radii) * around, len(radii) * around + 1, np.arange(around)
    after = np.roll(here, -1)
    triangles = [np.stack([np.full(around, low), here, after], axis=1)]
    for begin in around * np.arange(len(radii) - 1):
        a, b, c, d = here + begin, after + begin, here + begin + around, after + begin + around
        triangles += [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
    last = low - around
    triangles.append(np.stack([np.full(around, high), after + last, here + last], axis=1))
    return np.concatenate([rings.reshape(-1, 3), poles]), np.concatenate(triangles).astype(np.int32)


def _areas(corners: np.ndarray) -> np.ndarray:
    """Return the areas of triangles (m, corner, 3)."""
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def _halves(corners: np.ndarray) -> np.ndarray:
    """Cut triangles in two across their longest edges."""
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).argmax(axis=1)
    a, b, c = (corners[np.arange(len(corners)), (longest + step) % 3] for step in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])

"""Normals of a mesh's corners: smooth where its triangles bend a little, sharp at its edges."""

import numpy as np

CREASE_DEG = 40.0  # triangles that meet at a greater angle have an edge between them


def corner_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a normal for each corner of each triangle, by area, of all triangles there that bend little from it.

    Args:
        vertices: Shape (n, 3).
        triangles: Anticlockwise seen from outside, shape (m, 3).

    Returns:
        Unit vectors, shape (m, 3, 3).
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    flat = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), 1e-30)
    corner = np.argsort(triangles.reshape(-1), kind="stable")  # corners of one vertex follow one another
    vertex, face = triangles.reshape(-1)[corner], corner // 3
    first = np.searchsorted(vertex, vertex)
    count = np.searchsorted(vertex, vertex, side="right") - first
    total = np.zeros((len(corner), 3))
    for k in range(count.max(initial=0)):
        there = k < count
        other = face[np.minimum(first + k, len(face) - 1)]
        bends_little = (flat[face] * flat[other]).sum(axis=1) > np.cos(np.deg2rad(CREASE_DEG))
        total += np.where((there & bends_little)[:, None], areas[other], 0)
    normals = np.empty_like(total)
    normals[corner] = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
    return normals.reshape(-1, 3, 3)

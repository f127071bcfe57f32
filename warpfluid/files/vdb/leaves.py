"""Leaves: the cubes of 8^3 voxels that a tree stores, cut from an array and put in the order of the tree."""

from dataclasses import dataclass

import numpy as np

from warpfluid.files.vdb.layout import LEAF, LEAF_VOXELS, LOWER, UPPER


@dataclass(frozen=True)
class Leaves:
    """The leaves of an array that hold something, in the order of the tree.

    Attributes:
        first: Index of each leaf's first voxel, shape (leaf, 3).
        active: Each leaf's active voxels, shape (leaf, 512).
        values: Values of the active voxels, leaf after leaf, shape (voxel, components).
    """

    first: np.ndarray
    active: np.ndarray
    values: np.ndarray


def find_leaves(array: np.ndarray, first: np.ndarray, threshold: float) -> Leaves:
    """Cut an array into the leaves that hold an active voxel.

    Args:
        array: Grid in the axes of the file, shape (i, j, k[, 3]).
        first: Index of its first voxel, shape (3,); leaves begin at multiples of 8.
        threshold: A voxel is active when a component of it is further from zero than this.

    Returns:
        The leaves.
    """
    values = array.reshape(*array.shape[:3], -1)
    active = (np.abs(values) > threshold).any(-1)
    front = first % LEAF
    padding = [(int(f), int(-(f + side) % LEAF)) for f, side in zip(front, active.shape, strict=True)]
    cubes = as_cubes(np.pad(active, padding))
    occupied = np.argwhere(cubes.any((3, 4, 5)))
    corners = first - front + occupied * LEAF
    order = np.lexsort(np.column_stack(address(corners)).T[::-1])
    occupied = tuple(occupied[order].T)
    active = cubes[occupied]
    values = as_cubes(np.pad(values, [*padding, (0, 0)]))[occupied][active]
    return Leaves(corners[order], active.reshape(-1, LEAF_VOXELS), values)


def as_cubes(array: np.ndarray) -> np.ndarray:
    """View an array (i, j, k, ...) of whole leaves as leaves, shape (i/8, j/8, k/8, 8, 8, 8, ...)."""
    i, j, k = (side // LEAF for side in array.shape[:3])
    split = array.reshape(i, LEAF, j, LEAF, k, LEAF, *array.shape[3:])
    return split.transpose(0, 2, 4, 1, 3, 5, *range(6, split.ndim))


def address(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the way down the tree to leaves.

    Args:
        corners: Index of each leaf's first voxel, shape (leaf, 3).

    Returns:
        The upper node, shape (leaf, 3); the place of the lower node in it and of the leaf in that, (leaf,).
    """
    lower = corners % UPPER // LOWER @ [32 * 32, 32, 1]
    leaf = corners % LOWER // LEAF @ [16 * 16, 16, 1]
    return corners // UPPER, lower, leaf


def active_box(corners: np.ndarray, active: np.ndarray) -> np.ndarray | None:
    """Return the first and the last index of active voxels, shape (2, 3), or None where there is none."""
    cubes = active.reshape(-1, LEAF, LEAF, LEAF)
    if not cubes.any():
        return None
    spans = []
    for axis in range(3):
        others = tuple(1 + other for other in range(3) if other != axis)
        index = (corners[:, axis, None] + np.arange(LEAF))[cubes.any(others)]
        spans.append((index.min(), index.max()))
    return np.transpose(spans)

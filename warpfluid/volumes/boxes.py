"""Volumes in larger boxes."""

import numpy as np


def boxed(volume: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray | None:
    """Return a volume in the middle of a box, on its floor; None if it is larger.

    Args:
        volume: Shape (x, z, y).
        shape: Of the box (x, z, y).
    """
    room = [n - m for n, m in zip(shape, volume.shape, strict=True)]
    if min(room) < 0:
        return None
    return np.pad(volume, [*((n // 2, n - n // 2) for n in room[:2]), (0, room[2])]) if any(room) else volume


def squared(volume: np.ndarray) -> np.ndarray:
    """Return a volume, shape (x, z, y), in the middle of a box as deep as wide, so that it can turn."""
    width = max(volume.shape[:2])
    return boxed(volume, (width, width, volume.shape[2]))

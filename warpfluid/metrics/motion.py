"""Numbers of pictures in time: natural motion against flicker."""

import numpy as np


def left_over(now: np.ndarray, later: np.ndarray, back: np.ndarray) -> float:
    """Return what a picture's motion does not explain of the next one: flicker, and what comes and goes.

    Args:
        now: A picture, any shape of two axes.
        later: The next one, of the same shape.
        back: Displacement from ``later`` to ``now`` along each axis [pixel], shape (2, ...).

    Returns:
        Mean difference of ``later`` and of ``now`` moved, over the mean of ``later``; 0 where that is black.

    Raises:
        ValueError: If the shapes differ.
    """
    from scipy.ndimage import map_coordinates

    if now.shape != later.shape or back.shape != (2, *now.shape):
        raise ValueError(f"now, later and back have shapes {now.shape}, {later.shape} and {back.shape}: they must fit")
    moved = map_coordinates(np.asarray(now, np.float64), np.indices(now.shape) + back, order=1, mode="nearest")
    total = np.abs(later).sum(dtype=np.float64)
    return float(np.abs(later - moved).sum() / total) if total else 0.0

"""Pictures moved and enlarged by parts of pixels."""

import numpy as np


def move(picture: np.ndarray, shift: float, scale: float) -> np.ndarray:
    """Enlarge a picture about its middle, then move it up; what comes in from outside repeats the edge.

    The interpolation is a cubic that stays between its neighbours, so that black stays black, and keeps the light that
    the cubic has. By whole pixels the values stay as they are.

    Args:
        picture: Top row first, shape (rows, columns).
        shift: How far up [pixel].
        scale: How much larger.

    Source: Keys 1981, Cubic convolution interpolation for digital image processing.
    """
    rows, columns = (np.arange(length) - (length - 1) / 2 for length in picture.shape)
    if shift or scale != 1:
        picture = _resample(picture, (rows + shift) / scale - rows[0])
    if scale != 1:
        picture = _resample(picture.T, columns / scale - columns[0]).T
    return picture


def _resample(picture: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Interpolate rows at places between them."""
    last = len(picture) - 1
    places = places.clip(0, last)
    below = places.astype(int)
    t = (places - below).astype(np.float32)[:, None]
    a, b, c, d = (picture[(below + step).clip(0, last)] for step in (-1, 0, 1, 2))
    cubic = b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
    limited = np.clip(cubic, np.minimum(b, c), np.maximum(b, c))
    light, kept = cubic.sum(dtype=np.float64), limited.sum(dtype=np.float64)
    return limited * np.float32(max(light, 0.0) / kept) if kept > 0 else limited

"""Numbers of one volume."""

from collections.abc import Sequence

import numpy as np


def grid_index(volume: np.ndarray, angles_deg: Sequence[float] = (0, 90), half_width_deg: float = 6) -> float:
    """Measure how much a volume is woven along its inputs' rays, the mark of least squares.

    Args:
        volume: Density, shape (x, z, y).
        angles_deg: Angles of the input views.
        half_width_deg: How far from an input's direction energy counts as belonging to it.

    Returns:
        Energy of the slices' spectrum near the inputs' directions over an isotropic one's: natural fluid has
        about 1, least squares from two views 3 to 6.

    Raises:
        ValueError: If the volume is not 3D, too small to have a spectrum, or without structure.
    """
    volume = np.asarray(volume)
    if volume.ndim != 3 or min(volume.shape[:2]) < 8:
        raise ValueError(f"volume has shape {volume.shape}; slices of at least 8 x 8, (x, z, y), are needed")
    window = np.outer(np.hanning(volume.shape[0]), np.hanning(volume.shape[1]))
    power = np.zeros(window.shape)
    for k in range(volume.shape[2]):
        level = volume[:, :, k].astype(np.float64)
        power += np.abs(np.fft.fft2((level - level.mean()) * window)) ** 2
    fx, fz = (np.fft.fftfreq(n) for n in window.shape)
    length, direction = np.hypot(fx[:, None], fz), np.degrees(np.arctan2(fz, fx[:, None]))
    ring = (length > 0.06) & (length < 0.4)  # below is the silhouette, above the interpolation
    apart = [np.abs((direction - angle + 90) % 180 - 90) for angle in angles_deg]
    near = ring & (np.min(apart, axis=0) < half_width_deg)
    if not power[ring].any() or not near.any():
        raise ValueError("volume has no structure to measure; leave an empty frame out")
    return float(power[near].sum() / power[ring].sum() * ring.sum() / near.sum())

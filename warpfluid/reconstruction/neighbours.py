"""The two inputs that an unseen view lies between.

Orthographic views repeat mirrored after 180 degrees, so the neighbour beyond the last input is the first one flipped.
"""

import numpy as np


def around(images: np.ndarray, angles_deg: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Sort views by angle and continue them, mirrored, by one on either side.

    Args:
        images: Shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].

    Returns:
        The views with one more on either side, and their angles.
    """
    order = np.argsort(angles_deg)
    images, angles = np.asarray(images, np.float32)[order], np.asarray(angles_deg, np.float64)[order]
    images = np.concatenate([images[-1:, ::-1], images, images[:1, ::-1]])
    return images, np.concatenate([[angles[-1] - 180], angles, [angles[0] + 180]])


def between(angles: np.ndarray, fan_deg: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the left neighbour of each angle of a fan, and how far it is on the way to the right one, 0 to 1."""
    fan = np.asarray(fan_deg, np.float64)
    left = np.clip(np.searchsorted(angles, fan, side="right") - 1, 0, len(angles) - 2)
    return left, (fan - angles[left]) / (angles[left + 1] - angles[left])

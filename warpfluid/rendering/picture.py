"""A rendered picture before it is turned into display values: linear light and what is known of each pixel."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Picture:
    """What a camera sees, the top row first.

    Attributes:
        color: Light that reaches the camera, linear and premultiplied, float32, shape (rows, columns, 3).
        alpha: Share of the light from behind that is lost, 0 to 1, shape (rows, columns).
        depth: How far along the camera's forward half of the pixel's opacity and light are reached [voxel],
            infinity where there is nothing, shape (rows, columns).
        density: Sum of the density along the ray, up to ``limits``; nothing hides it; shape (rows, columns).
        emission: The part of ``color`` that the medium itself gave off, shape (rows, columns, 3).
        sky: Light from behind everything, which is not in ``color``, shape (rows, columns, 3); None for none.
    """

    color: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray
    density: np.ndarray
    emission: np.ndarray
    sky: np.ndarray | None = None

    def over(self, background: np.ndarray) -> np.ndarray:
        """Return the colour in front of a background, any shape that fits (rows, columns, 3)."""
        return self.color + (1 - self.alpha[..., None]) * np.asarray(background, np.float32)

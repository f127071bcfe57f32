"""Where light comes from: suns, and the sky around."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Sun:
    """A light so far away that its rays are parallel.

    Attributes:
        direction: To the light (x, y, z), of any length; y is up.
        color: Irradiance of a surface that faces it, red, green and blue.

    Raises:
        ValueError: If the direction has no length, or a number is not finite or a colour negative.
    """

    direction: np.ndarray
    color: np.ndarray

    def __post_init__(self):
        direction, color = np.asarray(self.direction, float), np.broadcast_to(np.asarray(self.color, float), (3,))
        if direction.shape != (3,) or not 0 < np.linalg.norm(direction) < np.inf:
            raise ValueError(f"direction of a sun is {self.direction}, expected (x, y, z) that is not 0")
        if not (np.isfinite(color).all() and color.min() >= 0):
            raise ValueError(f"color of a sun is {self.color}, expected finite numbers, 0 or more")
        object.__setattr__(self, "direction", direction / np.linalg.norm(direction))
        object.__setattr__(self, "color", color.copy())


@dataclass(frozen=True)
class Lighting:
    """All the light around a scene.

    Attributes:
        suns: Parallel lights.
        ambient: Radiance from everywhere else as order-2 spherical harmonics of the direction (x, y, z) it comes from,
            shape (9, 3), in the order (0, 0), (1, -1), (1, 0), (1, 1), (2, -2) ... (2, 2) with polar axis z.
    """

    suns: tuple[Sun, ...] = ()
    ambient: np.ndarray = field(default_factory=lambda: np.zeros((9, 3)))

    def __post_init__(self):
        ambient = np.asarray(self.ambient, float)
        if ambient.shape != (9, 3) or not np.isfinite(ambient).all():
            raise ValueError(f"ambient has shape {ambient.shape}, expected (9, 3) finite coefficients")
        object.__setattr__(self, "suns", tuple(self.suns))
        object.__setattr__(self, "ambient", ambient)

"""Light from all around as nine numbers a colour: real spherical harmonics of order 2.

Directions are (x, y, z), y up. The functions are orthonormal over the sphere, in the order of Ramamoorthi and Hanrahan,
"An Efficient Representation for Irradiance Environment Maps" (2001); radiance 1 all around is (sqrt(4 pi), 0, ...).
"""

import numpy as np

COSINE = np.array([np.pi] + 3 * [2 * np.pi / 3] + 5 * [np.pi / 4])  # what a cosine lobe leaves of each order


def harmonics(directions: np.ndarray) -> np.ndarray:
    """Return the nine functions in some directions.

    Args:
        directions: Unit vectors, shape (..., 3).

    Returns:
        Shape (..., 9).
    """
    x, y, z = np.moveaxis(np.asarray(directions, float), -1, 0)
    constant, linear, square = np.sqrt(1 / (4 * np.pi)), np.sqrt(3 / (4 * np.pi)), np.sqrt(15 / (4 * np.pi))
    parts = [
        np.full_like(x, constant),
        *(linear * y, linear * z, linear * x),
        *(square * x * y, square * y * z, square / np.sqrt(12) * (3 * z * z - 1), square * x * z),
        square / 2 * (x * x - y * y),
    ]
    return np.stack(parts, axis=-1)


def uniform(radiance: tuple[float, float, float]) -> np.ndarray:
    """Return the coefficients of one radiance all around, shape (9, 3)."""
    coefficients = np.zeros((9, 3))
    coefficients[0] = np.sqrt(4 * np.pi) * np.asarray(radiance)
    return coefficients


def sky(above: tuple[float, float, float], below: tuple[float, float, float]) -> np.ndarray:
    """Return the coefficients of a radiance that changes as the height of a direction does.

    Args:
        above: Straight above.
        below: Straight below.

    Returns:
        Shape (9, 3).
    """
    above, below = np.asarray(above, float), np.asarray(below, float)
    coefficients = uniform(tuple((above + below) / 2))
    coefficients[1] = np.sqrt(4 * np.pi / 3) * (above - below) / 2
    return coefficients


def radiance(coefficients: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the light from some directions (..., 3), never below 0, shape (..., 3)."""
    return np.maximum(harmonics(directions) @ coefficients, 0)


def irradiance(coefficients: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the light that falls onto surfaces with some normals (..., 3), never below 0, shape (..., 3)."""
    return np.maximum(harmonics(normals) @ (COSINE[:, None] * coefficients), 0)

"""The Poisson equation of an empty box, solved exactly: each axis in the basis that makes its Laplacian diagonal.

Along one axis the Laplacian is a small symmetric matrix whose ends say what the two sides are, so its eigenvectors
are the sines, cosines or Fourier modes that fit the sides (Buzbee, Golub and Nielson 1970). Changing basis is a matrix
product, which is faster here than a fast transform: a fluid is a few hundred voxels wide, often a prime number.
"""

import functools
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpfluid.kernels.poisson.modes import change_basis, invert_laplacian
from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP


def diagonalise(n: int, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvectors (columns) and eigenvalues of minus the Laplacian of a row of n voxels.

    Args:
        n: Number of voxels.
        low: What the side below the first is: OPEN (pressure 0 on the side itself), CLOSED or WRAP.
        high: What the side above the last is.
    """
    mode, place = np.arange(n), np.arange(n)[:, None] + 0.5
    if low == WRAP:
        turns = 2 * np.pi / n * ((mode + 1) // 2)  # a cosine and a sine each; as many of them as there are voxels
        vectors = np.where(mode % 2, np.cos(turns * place), np.sin(turns * place))
        vectors[:, 0] = 1.0
        if n % 2 == 0:
            vectors[:, -1] = (-1.0) ** mode
    else:
        turns = np.pi / n * (mode + {(OPEN, OPEN): 1.0, (CLOSED, CLOSED): 0.0}.get((low, high), 0.5))
        vectors = (np.sin if low == OPEN else np.cos)(turns * place)
    vectors /= np.linalg.norm(vectors, axis=0)
    return vectors.astype(np.float32), (2.0 - 2.0 * np.cos(turns)).astype(np.float32)


def solve(divergence: wp.array, sides: SIX, scratch: wp.array) -> wp.array:
    """Return the pressure whose Laplacian is a divergence; where nothing fixes its mean, the mean is 0.

    Args:
        divergence: Shape (x, z, y); overwritten.
        sides: What the sides of the box are.
        scratch: Memory of the same shape.

    Returns:
        The pressure, in ``divergence``.
    """
    device = str(divergence.device)
    axes = [_on(device, n, int(sides[2 * axis]), int(sides[2 * axis + 1])) for axis, n in enumerate(divergence.shape)]
    field, other = divergence, scratch
    for axis in (0, 1, 2):
        field, other = change_basis(field, axes[axis].modes, axis=axis, out=other), field
    invert_laplacian(*(axis.values for axis in axes), out=field)
    for axis in (2, 1, 0):
        field, other = change_basis(field, axes[axis].back, axis=axis, out=other), field
    return field


@dataclass(frozen=True)
class _Axis:
    """Modes along an axis as columns, as rows, and their eigenvalues."""

    modes: wp.array
    back: wp.array
    values: wp.array


@functools.lru_cache(maxsize=16)
def _on(device: str, n: int, low: int, high: int) -> _Axis:
    """Return the modes of a row of n voxels on a device."""
    vectors, values = diagonalise(n, low, high)
    parts = (vectors, np.ascontiguousarray(vectors.T), values)
    return _Axis(*(wp.array(part, dtype=float, device=device) for part in parts))

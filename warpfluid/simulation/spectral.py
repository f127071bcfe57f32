"""The Poisson equation of an empty box, solved exactly: each axis in the basis that makes its Laplacian diagonal.

Along one axis the Laplacian is a small symmetric matrix whose ends say what the two sides are, so its eigenvectors
are the sines, cosines or Fourier modes that fit the sides (Buzbee, Golub and Nielson 1970). Changing basis is a matrix
product, which is faster here than a fast transform: a fluid is a few hundred voxels wide, often a prime number.
"""

import functools

import numpy as np

from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP

ZERO = 1e-9  # an eigenvalue below is that of the constant; the next is (pi / n)^2


@functools.lru_cache(maxsize=16)
def diagonalise(n: int, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvectors (columns) and eigenvalues of minus the Laplacian of a row of n voxels.

    Args:
        n: Number of voxels.
        low: What the side below the first is: OPEN (pressure 0 on the side itself), CLOSED or WRAP.
        high: What the side above the last is.
    """
    matrix = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    for end, side in ((0, low), (n - 1, high)):
        matrix[end, end] += {OPEN: 1.0, CLOSED: -1.0, WRAP: 0.0}[side]
    if low == WRAP:
        matrix[0, n - 1] -= 1.0
        matrix[n - 1, 0] -= 1.0
    values, vectors = np.linalg.eigh(matrix)
    return vectors.astype(np.float32), np.where(values < ZERO, 0.0, values).astype(np.float32)


def solve(divergence: np.ndarray, sides: SIX, scratch: np.ndarray) -> np.ndarray:
    """Return the pressure whose Laplacian is a divergence; where nothing fixes its mean, the mean is 0.

    Args:
        divergence: Shape (x, z, y), C-contiguous float32; overwritten.
        sides: What the sides of the box are.
        scratch: Memory of the same shape.

    Returns:
        The pressure; in ``divergence`` or ``scratch``.
    """
    nx, _, ny = divergence.shape
    (x, values_x), (z, values_z), (y, values_y) = (
        diagonalise(n, int(sides[2 * axis]), int(sides[2 * axis + 1])) for axis, n in enumerate(divergence.shape)
    )
    a, b = divergence, scratch
    np.matmul(x.T, a.reshape(nx, -1), out=b.reshape(nx, -1))
    np.matmul(z.T, b, out=a)
    np.matmul(a.reshape(-1, ny), y, out=b.reshape(-1, ny))
    plane = values_z[:, None] + values_y
    for slab, value in zip(b, values_x, strict=True):
        total = plane + value
        slab *= np.divide(-1.0, total, out=np.zeros_like(total), where=total > 0.0)
    np.matmul(b.reshape(-1, ny), y.T, out=a.reshape(-1, ny))
    np.matmul(z, a, out=b)
    np.matmul(x, b.reshape(nx, -1), out=a.reshape(nx, -1))
    return a

"""The Poisson equation of an empty box, solved exactly: each axis in the basis that makes its Laplacian diagonal.

Along one axis the Laplacian is a small symmetric matrix whose ends say what the two sides are, so its eigenvectors
are the sines, cosines or Fourier modes that fit the sides (Buzbee, Golub and Nielson 1970). Changing basis is a matrix
product, which is faster here than a fast transform: a fluid is a few hundred voxels wide, often a prime number. Few
large products are made, no small ones: threads of a BLAS wait for each other in each.
"""

import functools

import numpy as np

from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP


@functools.lru_cache(maxsize=16)
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


def solve(divergence: np.ndarray, sides: SIX, scratch: np.ndarray) -> np.ndarray:
    """Return the pressure whose Laplacian is a divergence; where nothing fixes its mean, the mean is 0.

    Args:
        divergence: Shape (x, z, y), C-contiguous float32; overwritten.
        sides: What the sides of the box are.
        scratch: Memory of the same shape.

    Returns:
        The pressure; in ``divergence`` or ``scratch``.
    """
    nx, nz, ny = divergence.shape
    (x, values_x), (z, values_z), (y, values_y) = (
        diagonalise(n, int(sides[2 * axis]), int(sides[2 * axis + 1])) for axis, n in enumerate(divergence.shape)
    )
    a, b = divergence, scratch
    np.matmul(x.T, a.reshape(nx, -1), out=b.reshape(nx, -1))
    np.copyto(a.reshape(nz, nx, ny), b.transpose(1, 0, 2))
    np.matmul(z.T, a.reshape(nz, -1), out=b.reshape(nz, -1))
    np.matmul(b.reshape(-1, ny), y, out=a.reshape(-1, ny))
    plane = values_x[:, None] + values_y
    for slab, value in zip(a.reshape(nz, nx, ny), values_z, strict=True):
        total = plane + value
        slab *= np.divide(-1.0, total, out=np.zeros_like(total), where=total > 0.0)
    np.matmul(a.reshape(-1, ny), y.T, out=b.reshape(-1, ny))
    np.matmul(z, b.reshape(nz, -1), out=a.reshape(nz, -1))
    np.copyto(b, a.reshape(nz, nx, ny).transpose(1, 0, 2))
    np.matmul(x, b.reshape(nx, -1), out=a.reshape(nx, -1))
    return a

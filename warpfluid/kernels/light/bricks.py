"""The greatest value around every brick of voxels: where it is 0, a ray has nothing to meet."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import launch

wp.set_module_options({"enable_backward": False})

BRICK = 8  # voxels, a power of two
OVERLAP = 1  # a ray may leave its brick between two planes, and reads linearly one voxel further

GREATEST = f"""
    const int size[3] = {{field.shape[0], field.shape[1], field.shape[2]}}, at[3] = {{x, z, y}};
    int low[3], high[3];
    for (int i = 0; i < 3; ++i) {{
        low[i] = wp::max({BRICK} * at[i] - overlap, 0);
        high[i] = wp::min({BRICK} * (at[i] + 1) + 1 + overlap, size[i]);
    }}
    float most = 0.0f, bad = 0.0f;
    for (int i = low[0]; i < high[0]; ++i)
        for (int j = low[1]; j < high[1]; ++j) {{
            const float* run = field.data + ((size_t)i * size[1] + j) * size[2];
            for (int k = low[2]; k < high[2]; ++k) {{
                most = run[k] > most ? run[k] : most;
                bad += run[k] * 0.0f;  // not a number, if that or infinity is there
            }}
        }}
    out.data[((size_t)x * out.shape[1] + z) * out.shape[2] + y] = most + bad;
"""


@wp.func_native(snippet=GREATEST)
def greatest(field: wp.array3d[float], overlap: int, x: int, z: int, y: int, out: wp.array3d[float]):
    """Find the greatest value in and around a brick."""


@wp.kernel
def brick_kernel(first_row: int, first_block: int, field: wp.array3d[float], overlap: int, out: wp.array3d[float]):
    """Find the greatest values of a column of bricks."""
    i, z, j = wp.tid()
    if j == 0:
        for y in range(out.shape[2]):
            greatest(field, overlap, first_row + i, z, y, out)


def brick_maxima(
    field: wp.array3d[float], *, overlap: int = OVERLAP, out: wp.array3d[float] | None = None
) -> wp.array3d[float]:
    """Return the greatest value in every brick of 8 x 8 x 8 voxels and some voxels around it, at least 0.

    Args:
        field: Shape (x, z, y).
        overlap: Voxels around each brick, and one more above it.
        out: Array to write, shape (brick in x, in z, in y).

    Returns:
        The values; not a number where the field is not finite.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    checks.floats(3, field=field)
    shape = tuple(-(-n // BRICK) for n in field.shape)
    out = wp.empty(shape, dtype=float, device=field.device) if out is None else out
    device = checks.same_device(field=field, out=out)
    checks.floats(3, out=out)
    checks.shape(shape, out=out)
    launch(brick_kernel, (shape[0], shape[1], 1), [field, overlap], [out], device)
    return out

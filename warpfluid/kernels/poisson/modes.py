"""Fields in another basis along one axis, and the Laplacian where it is diagonal (Buzbee, Golub and Nielson 1970).

A change of basis is a matrix product. A BLAS would do it as fast, but with bits that depend on how many threads it
has. Here each sum runs over its axis in order, whoever adds it up.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch

wp.set_module_options({"enable_backward": False})

# A block of sums stays in registers. Across the height they are as wide as a run, and four modes or four columns deep.
SUM_BLOCK = """
        float sum[4][RUN] = {};
        if (some == 4 && count == RUN)
            for (int k = 0; k < size; ++k)
                for (int r = 0; r < 4; ++r)
                    for (int l = 0; l < RUN; ++l) sum[r][l] += share[r * along + k * across] * from[k * stride + l];
        else
            for (int k = 0; k < size; ++k)
                for (int r = 0; r < some; ++r)
                    for (int l = 0; l < count; ++l) sum[r][l] += share[r * along + k * across] * from[k * stride + l];
        for (int r = 0; r < some; ++r)
            for (int l = 0; l < count; ++l) to[r * step + l] = sum[r][l];
"""

ACROSS_HEIGHT = (
    """
    const int heights = field.shape[2], size = field.shape[axis];"""
    + RUN_OF_HEIGHTS
    + """
    const size_t plane = (size_t)field.shape[1] * heights, stride = axis ? heights : plane, step = stride;
    const size_t along = 1, across = size, start = row * (axis ? plane : heights) + y;
    for (int first = 0; first < size; first += 4) {
        const int some = size - first < 4 ? size - first : 4;
        const float *share = modes.data + first, *from = field.data + start;
        float* to = out.data + start + first * step;"""
    + SUM_BLOCK
    + """
    }
"""
)

ALONG_HEIGHT = (
    """
    const int heights = field.shape[2], columns = field.shape[1], size = heights;"""
    + RUN_OF_HEIGHTS
    + """
    const size_t stride = heights, step = heights, along = heights, across = 1;
    for (int first = 0; first < columns; first += 4) {
        const int some = columns - first < 4 ? columns - first : 4;
        const size_t start = ((size_t)row * columns + first) * heights;
        const float *share = field.data + start, *from = modes.data + y;
        float* to = out.data + start + y;"""
    + SUM_BLOCK
    + """
    }
"""
)

DIVIDE = (
    """
    const int heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const float plane = values_x.data[row] + values_z.data[column];
    float* to = out.data + ((size_t)row * out.shape[1] + column) * heights + y;
    for (int l = 0; l < count; ++l) {
        const float total = plane + values_y.data[y + l];
        to[l] = total > 0.0f ? -to[l] / total : 0.0f;
    }
"""
)


@wp.func_native(snippet=ACROSS_HEIGHT)
def sum_across_height(
    field: wp.array3d[float], modes: wp.array2d[float], axis: int, row: int, block: int, out: wp.array3d[float]
):
    """Find all coefficients along x or z, for a run of heights."""


@wp.func_native(snippet=ALONG_HEIGHT)
def sum_along_height(field: wp.array3d[float], modes: wp.array2d[float], row: int, block: int, out: wp.array3d[float]):
    """Find a run of coefficients along the height, for all columns of a row."""


@wp.kernel
def change_basis_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    modes: wp.array2d[float],
    axis: int,
    out: wp.array3d[float],
):
    """Find coefficients for one row and a run of heights."""
    i, _, j = wp.tid()
    row = first_row + i
    block = first_block + j
    if axis == 2:
        sum_along_height(field, modes, row, block, out)
    else:
        sum_across_height(field, modes, axis, row, block, out)


@wp.func_native(snippet=DIVIDE)
def divide_run(
    values_x: wp.array[float],
    values_z: wp.array[float],
    values_y: wp.array[float],
    row: int,
    column: int,
    block: int,
    out: wp.array3d[float],
):
    """Divide a run of coefficients by their eigenvalues; what is constant becomes 0."""


@wp.kernel
def invert_kernel(
    first_row: int,
    first_block: int,
    values_x: wp.array[float],
    values_z: wp.array[float],
    values_y: wp.array[float],
    out: wp.array3d[float],
):
    """Invert the Laplacian for one run of coefficients."""
    i, column, j = wp.tid()
    divide_run(values_x, values_z, values_y, first_row + i, column, first_block + j, out)


def change_basis(field: wp.array, modes: wp.array, *, axis: int, out: wp.array) -> wp.array:
    """Multiply each row of a field along an axis by a matrix: out_i = sum_k modes_ki field_k.

    Args:
        field: Shape (x, z, y).
        modes: Square, as long as the axis; its transpose goes back, where the modes are orthonormal.
        axis: 0 for x, 1 for z, 2 for y.
        out: Array to write, shape of ``field``, never ``field`` itself.

    Raises:
        ValueError: If arrays do not fit or the axis is none.
    """
    device = checks.same_device(field=field, modes=modes, out=out)
    checks.floats(3, field=field, out=out)
    checks.floats(2, modes=modes)
    checks.same_shape(field=field, out=out)
    if axis not in (0, 1, 2):
        raise ValueError(f"axis is {axis!r}, expected 0, 1 or 2")
    checks.shape((field.shape[axis],) * 2, modes=modes)
    rows = field.shape[1] if axis == 0 else field.shape[0]
    launch(change_basis_kernel, (rows, 1, field.shape[2]), [field, modes, axis], [out], device)
    return out


def invert_laplacian(values_x: wp.array, values_z: wp.array, values_y: wp.array, *, out: wp.array) -> wp.array:
    """Divide coefficients by the eigenvalues of the Laplacian, in place; the constant one, which it loses, becomes 0.

    Args:
        values_x: Eigenvalues of minus the Laplacian along x, one a mode.
        values_z: Along z.
        values_y: Along y.
        out: Coefficients, shape (x, z, y).

    Raises:
        ValueError: If arrays do not fit.
    """
    values = {"values_x": values_x, "values_z": values_z, "values_y": values_y}
    device = checks.same_device(out=out, **values)
    checks.floats(3, out=out)
    checks.floats(1, **values)
    for (name, array), count in zip(values.items(), out.shape, strict=True):
        checks.shape((count,), **{name: array})
    launch(invert_kernel, out.shape, list(values.values()), [out], device)
    return out

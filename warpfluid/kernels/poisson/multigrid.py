"""The Poisson equation on a staircase of ever coarser grids (Brandt 1977): relaxation and transfer.

The equation of a voxel: the sum over its faces of c (p - p_neighbour) is b. Beyond the box p is 0; on walls c is 0.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})

# Goes around where the side wraps; elsewhere what lies beyond is weighted by a coefficient that is 0 or meets p = 0.
STENCIL = (
    """
    const int nx = field.shape[0], nz = field.shape[1], heights = field.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const size_t column = ((size_t)x * nz + z) * heights + y, plane = (size_t)nz * heights;
    const float* here = field.data + column;
    const float *cx = c_x.data + column, *cz = c_z.data + column + x * heights;
    const float* cy = c_y.data + column + (size_t)x * nz + z;
    const float* near[6] = {x > 0 ? here - plane : wrap_x ? here + (nx - 1) * plane : 0,
                            x < nx - 1 ? here + plane : wrap_x ? here - (nx - 1) * plane : 0,
                            z > 0 ? here - heights : wrap_z ? here + (nz - 1) * heights : 0,
                            z < nz - 1 ? here + heights : wrap_z ? here - (nz - 1) * heights : 0};
    const float* c[6] = {cx, cx + plane, cz, cz + heights, cy, cy + 1};
    float sum[RUN] = {}, total[RUN] = {}, column_values[RUN + 2];
    for (int l = 0; l < count; ++l) column_values[l + 1] = here[l];
    column_values[0] = y > 0 ? here[-1] : wrap_y ? here[heights - 1] : 0.0f;
    column_values[count + 1] = y + count < heights ? here[count] : wrap_y ? here[count - heights] : 0.0f;
    near[4] = column_values;
    near[5] = column_values + 2;
    for (int side = 0; side < 6; ++side) {
        const float *weight = c[side], *from = near[side];
        for (int l = 0; l < count; ++l) total[l] += weight[l];
        if (from)
            for (int l = 0; l < count; ++l) sum[l] += weight[l] * from[l];
    }
    float* to = out.data + column;
    const float* b = right.data + column;
    if (!right.data)
        for (int l = 0; l < count; ++l) to[l] = total[l] * here[l] - sum[l];
    else if (weight_of_step == 0.0f) {
        for (int l = 0; l < count; ++l) to[l] = b[l] + sum[l] - total[l] * here[l];
        if (scale.data)
            for (int l = 0; l < count; ++l) to[l] *= scale.data[column + l];
    } else
        for (int l = 0; l < count; ++l) {
            const float step = (b[l] + sum[l]) / (total[l] > 0.0f ? total[l] : 1.0f) - here[l];
            to[l] = total[l] > 0.0f ? here[l] + weight_of_step * step : 0.0f;
        }
"""
)

# Across columns all heights share their taps; along one each height has its own.
COMBINE = (
    """
    const int nx = field.shape[0], nz = field.shape[1], ny = field.shape[2], heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const int taps = source.shape[1];
    float sum[RUN] = {};
    if (axis == 2) {
        const float* from = field.data + ((size_t)x * nz + z) * ny;
        for (int l = 0; l < count; ++l)
            for (int tap = (y + l) * taps; tap < (y + l + 1) * taps; ++tap)
                sum[l] += weight.data[tap] * from[source.data[tap]];
    } else
        for (int tap = (axis == 0 ? x : z) * taps, n = 0; n < taps; ++tap, ++n) {
            const int there = source.data[tap];
            const float* from = field.data + ((axis == 0 ? (size_t)there * nz + z : (size_t)x * nz + there) * ny + y);
            for (int l = 0; l < count; ++l) sum[l] += weight.data[tap] * from[l];
        }
    float* to = out.data + ((size_t)x * out.shape[1] + z) * heights + y;
    if (scale.data)
        for (int l = 0; l < count; ++l) to[l] += scale.data[to - out.data + l] * sum[l];
    else
        for (int l = 0; l < count; ++l) to[l] = sum[l];
"""
)


@wp.func_native(snippet=STENCIL)
def stencil_run(
    field: wp.array3d[float],
    right: wp.array3d[float],
    c_x: wp.array3d[float],
    c_z: wp.array3d[float],
    c_y: wp.array3d[float],
    wrap_x: bool,
    wrap_z: bool,
    wrap_y: bool,
    weight_of_step: float,
    scale: wp.array3d[float],
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Apply the equation to a run of heights, or take a step towards its solution."""


@wp.func_native(snippet=COMBINE)
def combine_run(
    field: wp.array3d[float],
    source: wp.array2d[int],
    weight: wp.array2d[float],
    axis: int,
    scale: wp.array3d[float],
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Weigh and add voxels of one axis for a run of heights."""


@wp.kernel
def stencil_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    right: wp.array3d[float],
    c_x: wp.array3d[float],
    c_z: wp.array3d[float],
    c_y: wp.array3d[float],
    sides: SIX,
    weight_of_step: float,
    scale: wp.array3d[float],
    out: wp.array3d[float],
):
    """Write A p, b - A p, or p after a weighted Jacobi step."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    wrap_x = sides[0] == WRAP
    wrap_z = sides[2] == WRAP
    wrap_y = sides[4] == WRAP
    stencil_run(field, right, c_x, c_z, c_y, wrap_x, wrap_z, wrap_y, weight_of_step, scale, x, z, block, out)


@wp.kernel
def combine_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    source: wp.array2d[int],
    weight: wp.array2d[float],
    axis: int,
    scale: wp.array3d[float],
    out: wp.array3d[float],
):
    """Weigh and add voxels of one axis."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    combine_run(field, source, weight, axis, scale, x, z, block, out)


def _check(shape: tuple[int, ...], voxels: dict, c_x: wp.array, c_z: wp.array, c_y: wp.array) -> wp.Device:
    """Check arrays in voxels and coefficients on faces; return their device."""
    faces = {"c_x": c_x, "c_z": c_z, "c_y": c_y}
    device = checks.same_device(**voxels, **faces)
    checks.floats(3, **voxels, **faces)
    checks.shape(shape, **voxels)
    for axis, (name, array) in enumerate(faces.items()):
        checks.shape(_face_shape(shape, axis), **{name: array})
    return device


def _face_shape(shape: tuple[int, ...], axis: int) -> tuple[int, ...]:
    return tuple(n + (k == axis) for k, n in enumerate(shape))


def apply(
    field: wp.array3d[float],
    c_x: wp.array3d[float],
    c_z: wp.array3d[float],
    c_y: wp.array3d[float],
    *,
    sides: SIX,
    right: wp.array3d[float] | None = None,
    step: float = 0.0,
    scale: wp.array3d[float] | None = None,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Write A p; with a right side b - A p; with a step also p after a weighted Jacobi step towards A p = b.

    Args:
        field: p, shape (x, z, y).
        c_x: Coefficients on the faces along x.
        c_z: Along z.
        c_y: Along y.
        sides: What the sides of the box are.
        right: b, of the field's shape.
        step: Weight of the Jacobi step. Voxels without an equation get 0.
        scale: Factor of b - A p, of the field's shape; 1 when omitted.
        out: Of the field's shape, never the field itself.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    given = {name: array for name, array in {"right": right, "scale": scale}.items() if array is not None}
    voxels = {"field": field, "out": out} | given
    device = _check(field.shape if isinstance(field, wp.array) else (), voxels, c_x, c_z, c_y)
    launch(
        stencil_kernel, out.shape, [field, right, c_x, c_z, c_y, sides, step, scale], [out], device, whole_columns=True
    )
    return out


def combine(
    field: wp.array3d[float],
    source: wp.array2d[int],
    weight: wp.array2d[float],
    *,
    axis: int,
    scale: wp.array3d[float] | None = None,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Write weighted sums of voxels along one axis: a step of going to a coarser or a finer grid.

    Args:
        field: Shape (x, z, y).
        source: Voxels to take along the axis, shape (n of ``out``, taps), within the field.
        weight: Of each, same shape.
        axis: 0 is x, 1 is z, 2 is y.
        scale: Factor of the sums, shape of ``out``; with it they are added to what is there.
        out: Shape of the field but for the axis.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    sums = {"out": out} | ({} if scale is None else {"scale": scale})
    device = checks.same_device(field=field, source=source, weight=weight, **sums)
    checks.floats(3, field=field, **sums)
    checks.same_shape(**sums)
    checks.typed(wp.int32, 2, source=source)
    checks.typed(wp.float32, 2, weight=weight)
    checks.same_shape(source=source, weight=weight)
    if source.shape[0] != out.shape[axis]:
        raise ValueError(f"source has {source.shape[0]} rows, expected {out.shape[axis]}: one for each voxel of out")
    checks.shape(tuple(field.shape[k] if k == axis else n for k, n in enumerate(out.shape)), field=field)
    launch(combine_kernel, out.shape, [field, source, weight, axis, scale], [out], device)
    return out

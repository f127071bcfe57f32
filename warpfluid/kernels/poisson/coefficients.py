"""The coefficients of the Poisson equation on the faces of the finest grid, and of ever coarser ones (Brandt 1977)."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})

# Half a voxel beyond an open side the pressure is 0; a wall passes nothing; both faces of a wrap are one face.
FACE_COEFFICIENT = (
    """
    const int heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const int n = out.shape[axis] - 1, first = axis == 0 ? x : axis == 1 ? z : y;
    const long long rows = out.shape[1], plane = rows * heights;
    const long long face_stride = axis == 0 ? plane : axis == 1 ? heights : 1;
    const long long ny = heights - (axis == 2), mass_plane = (rows - (axis == 1)) * ny;
    const long long stride = axis == 0 ? mass_plane : axis == 1 ? ny : 1;
    const long long face = x * plane + z * heights + y, voxel = x * mass_plane + z * ny + y;
    const float beyond[3] = {2.0f, 0.0f, 1.0f};
    for (int l = 0; l < count; ++l) {
        const int i = axis == 2 ? y + l : first, side = i == 0 ? low : i == n ? high : 2;
        const long long joined = side == 2 && i == n ? n : 0;
        float value = beyond[side];
        if (open.data) value *= open.data[face + l - joined * face_stride];
        if (mass.data) {
            const long long above = voxel + l - (i < n ? 0 : side == 2 ? n * stride : stride);
            const long long below = voxel + l + (i > 0 ? -stride : side == 2 ? (n - 1) * stride : 0);
            value *= 2.0f / (mass.data[above] + mass.data[below]);
        }
        out.data[face + l] = value;
    }
"""
)


@wp.func_native(snippet=FACE_COEFFICIENT)
def face_coefficient_run(
    open: wp.array3d[float],
    mass: wp.array3d[float],
    axis: int,
    low: int,
    high: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Write the coefficients of a run of faces."""


@wp.kernel
def face_coefficient_kernel(
    first_row: int,
    first_block: int,
    open: wp.array3d[float],
    mass: wp.array3d[float],
    axis: int,
    low: int,
    high: int,
    out: wp.array3d[float],
):
    """Divide a face's open share by the mass that its pressure difference moves."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    face_coefficient_run(open, mass, axis, low, high, x, z, block, out)


@wp.kernel
def coarsen_coefficient_kernel(
    first_row: int,
    first_block: int,
    fine: wp.array3d[float],
    axis: int,
    wrap: bool,
    run: int,
    out: wp.array3d[float],
):
    """Add the faces that a coarse face covers; divide by how much further apart the voxels now are."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        face = wp.vec3i(x, z, y)
        n = fine.shape[axis] - 1
        last = out.shape[axis] - 1
        at = face[axis]
        above = wp.where(at == last, int(0), at)
        below = wp.where(at == 0, last - 1, at - 1)
        if not wrap and at == 0:
            below = int(0)
        if not wrap and at == last:
            above = last - 1
        width = wp.min(2, n - 2 * below) + wp.min(2, n - 2 * above)
        start = 2 * face
        stop = wp.vec3i(0, 0, 0)
        for k in range(3):
            stop[k] = wp.min(start[k] + 2, fine.shape[k])
            if k == axis:
                start[k] = wp.min(start[k], n)
                stop[k] = start[k] + 1
        total = float(0.0)
        for a in range(start[0], stop[0]):
            for b in range(start[1], stop[1]):
                for c in range(start[2], stop[2]):
                    total += fine[a, b, c]
        out[x, z, y] = total * 2.0 / float(width)


def _face_shape(shape: tuple[int, ...], axis: int) -> tuple[int, ...]:
    return tuple(n + (k == axis) for k, n in enumerate(shape))


def _run(device: wp.Device) -> int:
    return CUDA_RUN if device.is_cuda else CPU_RUN


def face_coefficient(
    *,
    axis: int,
    sides: SIX,
    open: wp.array3d[float] | None = None,
    mass: wp.array3d[float] | None = None,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Write the coefficients of the finest grid on the faces of one axis: open share over mass density.

    Args:
        axis: 0 is x, 1 is z, 2 is y.
        sides: What the sides of the box are. An open side is half a voxel away, which doubles its coefficient.
        open: Share of each face that is fluid, shape of ``out``; 1 when omitted.
        mass: Relative mass density of each voxel, shape (x, z, y); 1 when omitted.
        out: On the faces of the axis.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    given = {"open": open, "mass": mass}
    extra = {name: array for name, array in given.items() if array is not None}
    device = checks.same_device(out=out, **extra)
    checks.floats(3, out=out, **extra)
    if open is not None:
        checks.same_shape(out=out, open=open)
    if mass is not None:
        checks.shape(_face_shape(mass.shape, axis), out=out)
    inputs = [open, mass, axis, sides[2 * axis], sides[2 * axis + 1]]
    launch(face_coefficient_kernel, out.shape, inputs, [out], device)
    return out


def coarsen_coefficient(fine: wp.array3d[float], *, axis: int, sides: SIX, out: wp.array3d[float]) -> wp.array3d[float]:
    """Write the coefficients on the faces of one axis of a grid half as fine.

    Args:
        fine: On the faces of the axis.
        axis: 0 is x, 1 is z, 2 is y.
        sides: What the sides of the box are.
        out: On the faces of a grid with half as many voxels along each axis, rounded up.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(fine=fine, out=out)
    checks.floats(3, fine=fine, out=out)
    halved = tuple((n - (k == axis) + 1) // 2 + (k == axis) for k, n in enumerate(fine.shape))
    checks.shape(halved, out=out)
    inputs = [fine, axis, sides[2 * axis] == WRAP, _run(device)]
    launch(coarsen_coefficient_kernel, out.shape, inputs, [out], device)
    return out

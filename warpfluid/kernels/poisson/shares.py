"""The shares of faces and voxels that shapes leave open, from signed distances at the voxels' corners.

A share is that of the positive part of a function that is linear on triangles or tetrahedra between the corners
(Ng, Min and Gibou 2009), so flat shapes are exact however they are turned.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, elementwise, launch

wp.set_module_options({"enable_backward": False})

FAR = 1.0e6  # voxels; beyond every distance
TOUCH = 1.0e-4  # voxels; a corner this near lies on the surface, so that rounding opens no face of a wall


@wp.func
def triangle_share(p: float, q: float, r: float) -> float:
    """Share of a triangle where the linear function of these corners is positive."""
    high = wp.max(p, wp.max(q, r))
    low = wp.min(p, wp.min(q, r))
    middle = wp.max(wp.min(p, q), wp.min(wp.max(p, q), r))
    share = float(0.0)
    if low >= 0.0 and high > 0.0:
        share = 1.0
    elif high > 0.0 and middle <= 0.0:
        share = high * high / ((high - middle) * (high - low))
    elif high > 0.0:
        share = 1.0 - low * low / ((low - high) * (low - middle))
    return share


@wp.func
def tetrahedron_share(p: float, q: float, r: float, s: float) -> float:
    """Share of a tetrahedron where the linear function of these corners is positive."""
    a = wp.max(wp.max(p, q), wp.max(r, s))
    d = wp.min(wp.min(p, q), wp.min(r, s))
    one = wp.min(wp.max(p, q), wp.max(r, s))
    other = wp.max(wp.min(p, q), wp.min(r, s))
    b = wp.max(one, other)
    c = wp.min(one, other)
    share = float(0.0)
    if d >= 0.0 and a > 0.0:
        share = 1.0
    elif a > 0.0 and b <= 0.0:
        share = a * a * a / ((a - b) * (a - c) * (a - d))
    elif a > 0.0 and c <= 0.0:
        wedge = a * a * b * b - (c + d) * a * b * (a + b) + c * d * (a * a + a * b + b * b)
        share = wedge / ((a - c) * (a - d) * (b - c) * (b - d))
    elif a > 0.0:
        share = 1.0 - d * d * d / ((d - a) * (d - b) * (d - c))
    return share


@wp.func
def corner(corners: wp.array3d[float], x: int, z: int, y: int, bits: int) -> float:
    """Distance at one of the eight corners, 0 where it lies on the surface."""
    value = corners[x + (bits & 1), z + ((bits >> 1) & 1), y + ((bits >> 2) & 1)]
    return wp.where(wp.abs(value) < TOUCH, 0.0, value)


@wp.func
def ring(axis: int, side: int, step: int) -> int:
    """Bits of a corner of a voxel's side, going round it: steps 0 to 3, then 0 again."""
    turn = step & 3
    u = int(turn == 1 or turn == 2) << ((axis + 1) % 3)
    v = int(turn >= 2) << ((axis + 2) % 3)
    return (side << axis) | u | v


@wp.kernel
def face_share_kernel(
    first_row: int,
    first_block: int,
    corners: wp.array3d[float],
    axis: int,
    first: wp.vec3i,
    heights: int,
    run: int,
    out: wp.array3d[float],
):
    """Measure how much of a face lies outside: four triangles around its middle."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, heights)):
        middle = float(0.0)
        low = float(FAR)
        high = float(-FAR)
        for step in range(4):
            value = corner(corners, x, z, y, ring(axis, 0, step))
            middle += 0.25 * value
            low = wp.min(low, value)
            high = wp.max(high, value)
        share = wp.where(low >= 0.0 and high > 0.0, 1.0, 0.0)
        if low < 0.0 and high > 0.0:
            for step in range(4):
                one = corner(corners, x, z, y, ring(axis, 0, step))
                two = corner(corners, x, z, y, ring(axis, 0, step + 1))
                share += 0.25 * triangle_share(middle, one, two)
        out[first[0] + x, first[1] + z, first[2] + y] = share


@wp.kernel
def voxel_share_kernel(
    first_row: int,
    first_block: int,
    corners: wp.array3d[float],
    first: wp.vec3i,
    run: int,
    out: wp.array3d[float],
):
    """Measure how much of a voxel lies outside: four tetrahedra around its centre for each side."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, corners.shape[2] - 1)):
        centre = float(0.0)
        low = float(FAR)
        high = float(-FAR)
        for bits in range(8):
            value = corner(corners, x, z, y, bits)
            centre += 0.125 * value
            low = wp.min(low, value)
            high = wp.max(high, value)
        share = wp.where(low >= 0.0 and high > 0.0, 24.0, 0.0)
        if low < 0.0 and high > 0.0:
            for side in range(6):
                middle = float(0.0)
                for step in range(4):
                    middle += 0.25 * corner(corners, x, z, y, ring(side >> 1, side & 1, step))
                for step in range(4):
                    one = corner(corners, x, z, y, ring(side >> 1, side & 1, step))
                    two = corner(corners, x, z, y, ring(side >> 1, side & 1, step + 1))
                    share += tetrahedron_share(centre, middle, one, two)
        out[first[0] + x, first[1] + z, first[2] + y] = share / 24.0


@wp.kernel
def hold_kernel(opening: wp.array[float], solid: wp.array[float], out: wp.array[float]):
    """Take the solid's velocity where a face is closed."""
    i = wp.tid()
    if opening[i] == 0.0:
        out[i] = solid[i]


@wp.kernel
def empty_covered_kernel(fluid: wp.array[float], out: wp.array[float]):
    """Fade out what lies in voxels that are less than half fluid."""
    i = wp.tid()
    out[i] = out[i] * wp.min(2.0 * fluid[i], 1.0)


def face_share(
    corners: wp.array3d[float], *, axis: int, first: tuple[int, int, int], out: wp.array3d[float]
) -> wp.array3d[float]:
    """Measure how much of each face of a block lies outside all shapes (Ng, Min and Gibou 2009).

    Args:
        corners: Signed distance at the corners of the block's voxels [voxel], one more an axis than voxels.
        axis: Axis that the faces cut: 0 is x, 1 is z, 2 is y.
        first: First voxel (x, z, y) of the block.
        out: Shares from 0 to 1 of all faces of the grid along the axis; those of the block are written.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(corners=corners, out=out)
    checks.floats(3, corners=corners, out=out)
    block = tuple(n - (k != axis) for k, n in enumerate(corners.shape))
    checks.block(first, block, out=out)
    inputs = [corners, axis, wp.vec3i(*first), block[2], _run(device)]
    launch(face_share_kernel, block, inputs, [out], device)
    return out


def voxel_share(
    corners: wp.array3d[float], *, first: tuple[int, int, int], out: wp.array3d[float]
) -> wp.array3d[float]:
    """Measure how much of each voxel of a block lies outside all shapes.

    Args:
        corners: Signed distance at the corners of the block's voxels [voxel], one more an axis than voxels.
        first: First voxel (x, z, y) of the block.
        out: Shares from 0 to 1 of all voxels of the grid; those of the block are written.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(corners=corners, out=out)
    checks.floats(3, corners=corners, out=out)
    block = tuple(n - 1 for n in corners.shape)
    checks.block(first, block, out=out)
    launch(voxel_share_kernel, block, [corners, wp.vec3i(*first), _run(device)], [out], device)
    return out


def hold(velocity: wp.array, opening: wp.array, solid: wp.array) -> wp.array:
    """Replace the velocity by the solid's where a face's open share is 0, in place."""
    return elementwise(hold_kernel, [opening, solid], velocity)


def empty_covered(field: wp.array, fluid: wp.array) -> wp.array:
    """Scale a field by twice the fluid's share, at most 1, in place."""
    return elementwise(empty_covered_kernel, [fluid], field)


def _run(device: wp.Device) -> int:
    return CUDA_RUN if device.is_cuda else CPU_RUN

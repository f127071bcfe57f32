"""The visual hull: the voxels that every input view sees lit (Ihrke and Magnor 2004)."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch, run_count

wp.set_module_options({"enable_backward": False})


@wp.kernel
def silhouette_hull_kernel(
    first_row: int,
    first_block: int,
    lit: wp.array3d[wp.uint8],
    directions: wp.array[wp.vec4],
    run: int,
    hull: wp.array3d[float],
):
    """Keep a voxel when its footprint touches a lit pixel in every view."""
    i, z, j = wp.tid()
    x = first_row + i
    begin = (first_block + j) * run
    n = hull.shape[0]
    middle = 0.5 * float(n - 1)
    for y in range(begin, wp.min(begin + run, hull.shape[2])):
        inside = float(1.0)
        for a in range(lit.shape[0]):
            direction = directions[a]
            q = (float(x) - middle) * direction[0] + (float(z) - middle) * direction[1] + middle
            low = q - 0.5 * direction[2] + 0.5
            first = int(wp.floor(low))
            seen = bool(False)
            if first >= 0 and first < n:
                seen = lit[a, first, y] > wp.uint8(0)
            # the second bin counts when more than rounding of the box reaches into it
            if first >= -1 and first < n - 1 and low + direction[2] > float(first + 1) + 1.0e-4:
                seen = seen or lit[a, first + 1, y] > wp.uint8(0)
            if not seen:
                inside = 0.0
        hull[x, z, y] = inside


@wp.kernel
def occupied_kernel(
    first_row: int, first_block: int, hull: wp.array3d[float], run: int, occupied: wp.array3d[wp.uint8]
):
    """Mark a run of heights that holds a voxel of the hull."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    any_inside = int(0)
    for y in range(block * run, wp.min(block * run + run, hull.shape[2])):
        if hull[x, z, y] > 0.0:
            any_inside = 1
    occupied[x, z, block] = wp.uint8(any_inside)


def silhouette_hull(
    lit: wp.array3d[wp.uint8], directions: wp.array[wp.vec4], *, out: wp.array3d[float] | None = None
) -> wp.array3d[float]:
    """Return the visual hull of silhouettes.

    Args:
        lit: 1 where a pixel belongs to the silhouette, shape (view, u, v).
        directions: cos t, sin t, m and 1 / m of every view's angle.
        out: Hull to write, shape (x, z, y).

    Returns:
        1 inside and 0 outside, shape (x, z, y).

    Raises:
        ValueError: If shapes or devices do not fit.
    """
    device = checks.same_device(lit=lit, directions=directions)
    checks.typed(wp.uint8, 3, lit=lit)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.shape((lit.shape[0],), directions=directions)
    _, width, heights = lit.shape
    out = wp.empty((width, width, heights), dtype=float, device=device) if out is None else out
    checks.same_device(lit=lit, out=out)
    checks.floats(3, out=out)
    checks.shape((width, width, heights), out=out)
    inputs = [lit, directions, _run(device)]
    launch(silhouette_hull_kernel, out.shape, inputs, [out], device)
    return out


def occupied_runs(hull: wp.array3d[float]) -> wp.array3d[wp.uint8]:
    """Return which runs of heights hold a voxel of the hull, shape (x, z, run)."""
    device = checks.same_device(hull=hull)
    checks.floats(3, hull=hull)
    width, depth, heights = hull.shape
    occupied = wp.empty((width, depth, run_count(heights, device)), dtype=wp.uint8, device=device)
    launch(occupied_kernel, hull.shape, [hull, _run(device)], [occupied], device)
    return occupied


def _run(device: wp.Device) -> int:
    return CUDA_RUN if device.is_cuda else CPU_RUN

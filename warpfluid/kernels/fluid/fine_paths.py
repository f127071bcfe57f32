"""A coarse field on a finer grid: read through a cubic spline where fine eddies have taken it from."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.blur import convolve
from warpfluid.kernels.fluid.faces import launch_run
from warpfluid.kernels.sampling import spline_taps, spline_weights

wp.set_module_options({"enable_backward": False})


@wp.func
def trilinear_vector(field: wp.array3d[wp.vec3], at: wp.vec3) -> wp.vec3:
    """Interpolate vectors linearly, the nearest voxel's beyond the border."""
    i = wp.clamp(at[0], 0.0, float(field.shape[0] - 1))
    j = wp.clamp(at[1], 0.0, float(field.shape[1] - 1))
    k = wp.clamp(at[2], 0.0, float(field.shape[2] - 1))
    i0, j0, k0 = int(i), int(j), int(k)
    i1, j1, k1 = (
        wp.min(i0 + 1, field.shape[0] - 1),
        wp.min(j0 + 1, field.shape[1] - 1),
        wp.min(k0 + 1, field.shape[2] - 1),
    )
    a, b, c = i - float(i0), j - float(j0), k - float(k0)
    near = wp.lerp(
        wp.lerp(field[i0, j0, k0], field[i0, j0, k1], c), wp.lerp(field[i0, j1, k0], field[i0, j1, k1], c), b
    )
    far = wp.lerp(wp.lerp(field[i1, j0, k0], field[i1, j0, k1], c), wp.lerp(field[i1, j1, k0], field[i1, j1, k1], c), b)
    return wp.lerp(near, far, a)


@wp.kernel
def follow_back_kernel(
    first_row: int, first_block: int, flow: wp.array3d[wp.vec3], steps: int, run: int, out: wp.array3d[wp.vec3]
):
    """Go against the flow from a voxel, by the midpoint rule; where it rests there is nowhere to go."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    step = 1.0 / float(steps)
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        at = wp.vec3(float(x), float(z), float(y))
        if wp.length_sq(flow[x, z, y]) > 0.0:
            for _ in range(steps):
                half_way = at - 0.5 * step * trilinear_vector(flow, at)
                at = at - step * trilinear_vector(flow, half_way)
        out[x, z, y] = at


@wp.kernel
def sample_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    spline: wp.array3d[float],
    cover: wp.array3d[float],
    path: wp.array3d[wp.vec3],
    factor: float,
    run: int,
    out: wp.array3d[float],
):
    """Sum the splines around the end of a path, within the eight values around it; uncovered voxels are 0."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    nx, nz, ny = spline.shape[0], spline.shape[1], spline.shape[2]
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        total = float(0.0)
        at = (path[x, z, y] + wp.vec3(0.5)) / factor - wp.vec3(0.5)
        i, j, k = int(wp.floor(at[0])), int(wp.floor(at[1])), int(wp.floor(at[2]))
        x0, x1 = wp.clamp(i, 0, nx - 1), wp.clamp(i + 1, 0, nx - 1)
        z0, z1 = wp.clamp(j, 0, nz - 1), wp.clamp(j + 1, 0, nz - 1)
        if cover[x0, z0, wp.clamp(k, 0, ny - 1)] > 0.0:
            wx = spline_weights(at[0] - float(i))
            wz = spline_weights(at[1] - float(j))
            wy = spline_weights(at[2] - float(k))
            y0, y1 = wp.clamp(k - 1, 0, ny - 1), wp.clamp(k, 0, ny - 1)
            y2, y3 = wp.clamp(k + 1, 0, ny - 1), wp.clamp(k + 2, 0, ny - 1)
            for p in range(4):
                a = wp.clamp(i + p - 1, 0, nx - 1)
                for q in range(4):
                    b = wp.clamp(j + q - 1, 0, nz - 1)
                    near = wy[0] * spline[a, b, y0] + wy[1] * spline[a, b, y1]
                    far = wy[2] * spline[a, b, y2] + wy[3] * spline[a, b, y3]
                    total += wx[p] * wz[q] * (near + far)
            low = wp.vec4(field[x0, z0, y1], field[x0, z1, y1], field[x1, z0, y1], field[x1, z1, y1])
            high = wp.vec4(field[x0, z0, y2], field[x0, z1, y2], field[x1, z0, y2], field[x1, z1, y2])
            total = wp.clamp(total, wp.min(wp.min(low), wp.min(high)), wp.max(wp.max(low), wp.max(high)))
        out[x, z, y] = total


def follow_back(flow: wp.array3d[wp.vec3], *, steps: int, out: wp.array3d[wp.vec3]) -> wp.array3d[wp.vec3]:
    """Return where what is in each voxel came from after a unit of time in a steady flow.

    Args:
        flow: Components (x, z, y) [voxel/unit of time], shape (x, z, y).
        steps: Of the midpoint rule.
        out: Places (x, z, y) [voxel], the same shape; never ``flow`` itself.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit or there are no steps.
    """
    checks.same_device(flow=flow, out=out)
    checks.typed(wp.vec3, 3, flow=flow, out=out)
    checks.same_shape(flow=flow, out=out)
    if steps < 1 or out is flow:
        raise ValueError(f"steps is {steps}, expected 1 or more, and out another array than the flow")
    launch_run(follow_back_kernel, [flow, steps], out)
    return out


def sample(
    field: wp.array3d[float],
    path: wp.array3d[wp.vec3],
    *,
    factor: int,
    cover: wp.array3d[float],
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Read a coarse field through a cubic spline where the paths of fine voxels end.

    Args:
        field: Shape (x, z, y).
        path: Where to read for each fine voxel (x, z, y) [fine voxel].
        factor: Fine voxels in a coarse one, along each axis.
        cover: Coarse; where it is 0 the result is 0, without a look.
        out: Fine field to write, within the values of the eight coarse voxels around.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(field=field, path=path, cover=cover, out=out)
    checks.floats(3, field=field, cover=cover, out=out)
    checks.typed(wp.vec3, 3, path=path)
    checks.same_shape(field=field, cover=cover)
    checks.shape(tuple(factor * n for n in field.shape), path=path, out=out)
    spline = convolve(field, (spline_taps(str(device)),) * 3)
    launch_run(sample_kernel, [field, spline, cover, path, float(factor)], out)
    return out

"""Carry a field along a velocity, backwards in time (Stam 1999).

Paths are traced with the midpoint rule. The value is taken from a cubic B-spline through the field, which keeps fine
detail that linear interpolation loses, and is kept within the eight voxels around the source, so nothing overshoots.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.blur import convolve
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch
from warpfluid.kernels.sampling import fetch, spline_taps, spline_weights, trilinear

wp.set_module_options({"enable_backward": False})


@wp.kernel
def advect_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    spline: wp.array3d[float],
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    time_step: float,
    run: int,
    out: wp.array3d[float],
):
    """Fetch each voxel's value from where it was one time step ago."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        here = wp.vec3(float(x), float(z), float(y))
        half = here - 0.5 * time_step * wp.vec3(velocity_x[x, z, y], velocity_z[x, z, y], velocity_y[x, z, y])
        back = wp.vec3(trilinear(velocity_x, half), trilinear(velocity_z, half), trilinear(velocity_y, half))
        source = here - time_step * back
        i = int(wp.floor(source[0]))
        j = int(wp.floor(source[1]))
        k = int(wp.floor(source[2]))
        low = float(0.0)
        high = float(0.0)
        for corner in range(8):
            value = fetch(field, i + (corner & 1), j + ((corner >> 1) & 1), k + ((corner >> 2) & 1))
            low = wp.where(corner == 0, value, wp.min(low, value))
            high = wp.where(corner == 0, value, wp.max(high, value))
        total = float(0.0)
        if high > low:
            wx = spline_weights(source[0] - float(i))
            wz = spline_weights(source[1] - float(j))
            wy = spline_weights(source[2] - float(k))
            for p in range(4):
                for q in range(4):
                    for r in range(4):
                        weight = wx[p] * wz[q] * wy[r]
                        total += weight * fetch(spline, i + p - 1, j + q - 1, k + r - 1)
        out[x, z, y] = wp.clamp(total, low, high)


def advect(
    field: wp.array3d[float],
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    time_step: float = 1.0,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Move a field along the velocity for one time step.

    Args:
        field: Shape (x, z, y); 0 beyond its border.
        velocity_x: Velocity along x [voxel/frame], of the field's shape.
        velocity_z: Along z.
        velocity_y: Along y, up.
        time_step: Duration of the step [frame].
        out: Array to write, never one of the others; a new one when omitted.

    Returns:
        The moved field, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    arrays = {"velocity_x": velocity_x, "velocity_z": velocity_z, "velocity_y": velocity_y, "out": out}
    device = checks.same_device(field=field, **arrays)
    checks.floats(3, field=field, **arrays)
    checks.same_shape(field=field, **arrays)
    spline = convolve(field, (spline_taps(str(device)),) * 3)
    inputs = [field, spline, velocity_x, velocity_z, velocity_y, time_step, CUDA_RUN if device.is_cuda else CPU_RUN]
    launch(advect_kernel, field.shape, inputs, [out], device)
    return out

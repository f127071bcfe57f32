"""Carry a field along a velocity, backwards in time (Stam 1999).

Paths are traced with the midpoint rule. The value is taken from a cubic B-spline through the field, which keeps fine
detail that linear interpolation loses, and is kept within the eight voxels around the source, so nothing overshoots.
"""

import functools
import math

import numpy as np
import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.blur import convolve
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, launch

wp.set_module_options({"enable_backward": False})

SPLINE_POLE = math.sqrt(3.0) - 2.0
SPLINE_REACH = 12  # taps either side; the filter falls by 3.7 a tap


@wp.func
def trilinear(field: wp.array3d[float], at: wp.vec3) -> float:
    """Interpolate linearly, the nearest voxel's value beyond the border."""
    i = wp.clamp(at[0], 0.0, float(field.shape[0] - 1))
    j = wp.clamp(at[1], 0.0, float(field.shape[1] - 1))
    k = wp.clamp(at[2], 0.0, float(field.shape[2] - 1))
    i0 = wp.min(int(i), wp.max(field.shape[0] - 2, 0))
    j0 = wp.min(int(j), wp.max(field.shape[1] - 2, 0))
    k0 = wp.min(int(k), wp.max(field.shape[2] - 2, 0))
    i1 = wp.min(i0 + 1, field.shape[0] - 1)
    j1 = wp.min(j0 + 1, field.shape[1] - 1)
    k1 = wp.min(k0 + 1, field.shape[2] - 1)
    a = i - float(i0)
    b = j - float(j0)
    c = k - float(k0)
    near = wp.lerp(
        wp.lerp(field[i0, j0, k0], field[i0, j0, k1], c), wp.lerp(field[i0, j1, k0], field[i0, j1, k1], c), b
    )
    far = wp.lerp(wp.lerp(field[i1, j0, k0], field[i1, j0, k1], c), wp.lerp(field[i1, j1, k0], field[i1, j1, k1], c), b)
    return wp.lerp(near, far, a)


@wp.func
def fetch(field: wp.array3d[float], i: int, j: int, k: int) -> float:
    """Return a voxel, 0 beyond the border."""
    if i < 0 or j < 0 or k < 0 or i >= field.shape[0] or j >= field.shape[1] or k >= field.shape[2]:
        return float(0.0)
    return field[i, j, k]


@wp.func
def spline_weights(t: float) -> wp.vec4:
    """Weights of the cubic B-spline at a fraction of a voxel."""
    r = 1.0 - t
    return wp.vec4(
        r * r * r / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0,
        t * t * t / 6.0,
    )


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


@functools.cache
def _spline_taps(device: str) -> wp.array:
    """The filter that turns values into coefficients of the cubic B-spline through them."""
    taps = SPLINE_POLE ** np.abs(np.arange(-SPLINE_REACH, SPLINE_REACH + 1))
    return wp.array(taps / taps.sum(), dtype=float, device=device)


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
    spline = convolve(field, (_spline_taps(str(device)),) * 3)
    inputs = [field, spline, velocity_x, velocity_z, velocity_y, time_step, CUDA_RUN if device.is_cuda else CPU_RUN]
    launch(advect_kernel, field.shape, inputs, [out], device)
    return out

"""Separable Gaussian blur of a volume; it ends the E-step and stands in for a ramp filter in the solver.

Beyond the box the volume is its own mirror image, so that a blur keeps the total.
"""

import functools
from collections.abc import Sequence

import numpy as np
import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch

wp.set_module_options({"enable_backward": False})

TRUNCATE = 4.0  # standard deviations; beyond them a Gaussian weighs less than float32 resolves

ACROSS_COLUMNS = (
    """
    const int nx = field.shape[0], nz = field.shape[1], heights = field.shape[2], radius = taps.shape[0] / 2;"""
    + RUN_OF_HEIGHTS
    + """
    const int n = axis == 0 ? nx : nz, here = axis == 0 ? x : z;
    float sum[RUN] = {};
    for (int tap = -radius; tap <= radius; ++tap) {
        int there = here + tap;
        while (there < 0 || there >= n) there = there < 0 ? -1 - there : 2 * n - 1 - there;
        const size_t column = axis == 0 ? (size_t)there * nz + z : (size_t)x * nz + there;
        const float* from = field.data + column * heights + y;
        const float weight = taps.data[tap + radius];
        if (count < RUN)
            for (int l = 0; l < count; ++l) sum[l] += weight * from[l];
        else
            for (int l = 0; l < RUN; ++l) sum[l] += weight * from[l];
    }
    float* to = out.data + ((size_t)x * nz + z) * heights + y;
    for (int l = 0; l < count; ++l) to[l] = sum[l];
"""
)

ALONG_COLUMN = (
    """
    const int heights = field.shape[2], radius = taps.shape[0] / 2;"""
    + RUN_OF_HEIGHTS
    + """
    const size_t column = ((size_t)x * field.shape[1] + z) * heights;
    const float* from = field.data + column;
    float sum[RUN] = {};
    for (int tap = -radius; tap <= radius; ++tap) {
        const float weight = taps.data[tap + radius];
        if (y + tap >= 0 && y + tap + count <= heights)
            for (int l = 0; l < count; ++l) sum[l] += weight * from[y + tap + l];
        else
            for (int l = 0; l < count; ++l) {
                int there = y + tap + l;
                while (there < 0 || there >= heights) there = there < 0 ? -1 - there : 2 * heights - 1 - there;
                sum[l] += weight * from[there];
            }
    }
    for (int l = 0; l < count; ++l) out.data[column + y + l] = sum[l];
"""
)


@wp.func_native(snippet=ACROSS_COLUMNS)
def blur_across(
    field: wp.array3d[float],
    taps: wp.array[float],
    axis: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Weigh a run of heights of neighbouring columns."""


@wp.func_native(snippet=ALONG_COLUMN)
def blur_along(field: wp.array3d[float], taps: wp.array[float], x: int, z: int, block: int, out: wp.array3d[float]):
    """Weigh neighbouring heights of a column."""


@wp.kernel
def blur_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    taps: wp.array[float],
    axis: int,
    out: wp.array3d[float],
):
    """Convolve one axis with symmetric taps: 0 is x, 1 is z, 2 is y."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    if axis == 2:
        blur_along(field, taps, x, z, block, out)
    else:
        blur_across(field, taps, axis, x, z, block, out)


@functools.lru_cache(maxsize=32)
def gaussian_taps(sigma: float, device: str) -> wp.array[float]:
    """Return the weights of a sampled Gaussian, total 1, as an array of odd length."""
    radius = int(TRUNCATE * sigma + 0.5)
    weights = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    return wp.array(weights / weights.sum(), dtype=float, device=device)


def blur(
    field: wp.array3d[float],
    sigma: float | tuple[float, float, float],
    *,
    scratch: wp.array3d[float] | None = None,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Blur a volume with a 3D Gaussian, as at the end of each E-step (Section 3.1).

    Args:
        field: Shape (x, z, y).
        sigma: Standard deviation, or one an axis (x, z, y); 0 leaves an axis alone [voxel].
        scratch: Memory of the field's shape to work in.
        out: Volume to write; it may be ``field``.

    Returns:
        The blurred volume, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit or sigma is negative.
    """
    sigmas = (sigma,) * 3 if isinstance(sigma, int | float) else tuple(sigma)
    if len(sigmas) != 3 or min(sigmas) < 0:
        raise ValueError(f"sigma is {sigma}, expected a number >= 0 or three, in voxels")
    device = str(checks.same_device(field=field))
    taps = [gaussian_taps(float(width), device) if width else None for width in sigmas]
    return convolve(field, taps, scratch=scratch, out=out)


def convolve(
    field: wp.array3d[float],
    taps: Sequence[wp.array[float] | None],
    *,
    scratch: wp.array3d[float] | None = None,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Convolve a volume with symmetric taps along each axis.

    Args:
        field: Shape (x, z, y).
        taps: An odd number of weights for x, z and y; None leaves an axis alone.
        scratch: Memory of the field's shape to work in.
        out: Volume to write; it may be ``field``.

    Returns:
        The result, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    scratch = wp.empty_like(field) if scratch is None else scratch
    out = wp.empty_like(field) if out is None else out
    device = checks.same_device(field=field, scratch=scratch, out=out)
    checks.floats(3, field=field, scratch=scratch, out=out)
    checks.same_shape(field=field, scratch=scratch, out=out)
    source = field
    for axis, weights in enumerate(taps):
        if weights is None:
            continue
        checks.same_device(field=field, taps=weights)
        checks.floats(1, taps=weights)
        target = scratch if source is not scratch else out
        launch(blur_kernel, field.shape, [source, weights, axis], [target], device)
        source = target
    if source is not out:
        wp.copy(out, source)
    return out

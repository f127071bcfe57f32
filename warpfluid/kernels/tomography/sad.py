"""The sum of absolute differences between neighbours (SAD), and the steps of a primal-dual solver that minimises it.

Voxels have six neighbours, and every pair counts once. The dual of a pair is a number between -weight and weight, kept
at the voxel of the lower index: paths[axis, x, z, y] belongs to the pair that follows (x, z, y) along the axis
(Chambolle and Pock 2011).
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, elementwise, launch, run_count

wp.set_module_options({"enable_backward": False})

# Offsets of a run and of its neighbours: `here`, and `next` or `last` along x and z, 0 apart at the box's end.
PLACES = (
    """
    const int nx = volume.shape[0], nz = volume.shape[1], heights = volume.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    const size_t here = ((size_t)x * nz + z) * heights + y, along_x = (size_t)nz * heights, along_z = heights;
"""
)

RUN_SAD = (
    PLACES
    + """
    const float* v = volume.data + here;
    const size_t dx = x + 1 < nx ? along_x : 0, dz = z + 1 < nz ? along_z : 0;
    double sum = 0.0;
    for (int l = 0; l < count; ++l) {
        const int dy = y + l + 1 < heights ? 1 : 0;
        sum += wp::abs(v[l + dx] - v[l]) + wp::abs(v[l + dz] - v[l]) + wp::abs(v[l + dy] - v[l]);
    }
    return sum;
"""
)

RAISE_DUAL = (
    PLACES
    + """
    const float* v = volume.data + here;
    const size_t dx = x + 1 < nx ? along_x : 0, dz = z + 1 < nz ? along_z : 0, size = (size_t)nx * along_x;
    float *px = dual.data + here, *pz = px + size, *py = pz + size;
    for (int l = 0; l < count; ++l) px[l] = wp::clamp(px[l] + step * (v[l + dx] - v[l]), -weight, weight);
    for (int l = 0; l < count; ++l) pz[l] = wp::clamp(pz[l] + step * (v[l + dz] - v[l]), -weight, weight);
    for (int l = 0; l < count; ++l) {
        const int dy = y + l + 1 < heights ? 1 : 0;
        py[l] = wp::clamp(py[l] + step * (v[l + dy] - v[l]), -weight, weight);
    }
"""
)

LOWER_PRIMAL = (
    PLACES
    + """
    const size_t size = (size_t)nx * along_x;
    const float *px = dual.data + here, *pz = px + size, *py = pz + size, *g = gradient.data + here;
    const float *bx = x > 0 ? px - along_x : px, *bz = z > 0 ? pz - along_z : pz;
    const float ex = x > 0 ? 1.0f : 0.0f, ez = z > 0 ? 1.0f : 0.0f;
    for (int l = 0; l < count; ++l) {
        const float below = y + l > 0 ? py[l - 1] : 0.0f;
        const float spread = ex * bx[l] - px[l] + ez * bz[l] - pz[l] + below - py[l];
        const float was = volume.data[here + l];
        const float now = hull.data[here + l] > 0.0f ? wp::max(was - step * (g[l] + spread), 0.0f) : 0.0f;
        volume.data[here + l] = now;
        ahead.data[here + l] = 2.0f * now - was;
    }
"""
)


@wp.func_native(snippet=RUN_SAD)
def run_sad(volume: wp.array3d[float], x: int, z: int, block: int) -> wp.float64:
    """Add up the differences of a run of heights to what follows."""


@wp.func_native(snippet=RAISE_DUAL)
def raise_run(
    volume: wp.array3d[float], step: float, weight: float, x: int, z: int, block: int, dual: wp.array4d[float]
):
    """Raise the duals of a run of heights."""


@wp.func_native(snippet=LOWER_PRIMAL)
def lower_run(
    gradient: wp.array3d[float],
    dual: wp.array4d[float],
    hull: wp.array3d[float],
    step: float,
    x: int,
    z: int,
    block: int,
    volume: wp.array3d[float],
    ahead: wp.array3d[float],
):
    """Lower a run of heights."""


@wp.kernel
def sad_kernel(first_row: int, first_block: int, volume: wp.array3d[float], partial: wp.array3d[wp.float64]):
    """Add up the differences of one run of heights."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    partial[x, z, block] = run_sad(volume, x, z, block)


@wp.kernel
def raise_kernel(
    first_row: int, first_block: int, volume: wp.array3d[float], step: float, weight: float, dual: wp.array4d[float]
):
    """Take a dual step for one run of heights."""
    i, z, j = wp.tid()
    raise_run(volume, step, weight, first_row + i, z, first_block + j, dual)


@wp.kernel
def lower_kernel(
    first_row: int,
    first_block: int,
    gradient: wp.array3d[float],
    dual: wp.array4d[float],
    hull: wp.array3d[float],
    step: float,
    volume: wp.array3d[float],
    ahead: wp.array3d[float],
):
    """Take a primal step for one run of heights."""
    i, z, j = wp.tid()
    lower_run(gradient, dual, hull, step, first_row + i, z, first_block + j, volume, ahead)


@wp.kernel
def raise_views_kernel(rendered: wp.array[float], wanted: wp.array[float], step: float, out: wp.array[float]):
    """Take a dual step for one pixel of the squared difference."""
    i = wp.tid()
    out[i] = (out[i] + step * (rendered[i] - wanted[i])) / (1.0 + 0.5 * step)


def sad(volume: wp.array3d[float]) -> float:
    """Return the sum of absolute differences between neighbours, in float64.

    Args:
        volume: Shape (x, z, y).

    Raises:
        ValueError: If the type does not fit.
    """
    device = checks.same_device(volume=volume)
    checks.floats(3, volume=volume)
    rows, columns, heights = volume.shape
    partial = wp.empty((rows, columns, run_count(heights, device)), dtype=wp.float64, device=device)
    launch(sad_kernel, volume.shape, [volume], [partial], device)
    return float(partial.numpy().sum())


def raise_dual(volume: wp.array3d[float], dual: wp.array4d[float], *, step: float, weight: float) -> None:
    """Take a dual step of the sum of absolute differences, in place.

    Args:
        volume: Shape (x, z, y).
        dual: Shape (3, x, z, y); of a last voxel's pair, which does not exist, 0.
        step: Its length.
        weight: Of the sum; no dual exceeds it.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(volume=volume, dual=dual)
    checks.floats(3, volume=volume)
    checks.floats(4, dual=dual)
    checks.shape((3, *volume.shape), dual=dual)
    launch(raise_kernel, volume.shape, [volume, step, weight], [dual], device)


def lower_primal(
    gradient: wp.array3d[float],
    dual: wp.array4d[float],
    hull: wp.array3d[float],
    volume: wp.array3d[float],
    ahead: wp.array3d[float],
    *,
    step: float,
) -> None:
    """Take a primal step, in place, staying inside the hull and at or above 0.

    Args:
        gradient: Back-projected duals of the views, shape (x, z, y).
        dual: Of the differences, shape (3, x, z, y).
        hull: 0 outside, shape (x, z, y).
        volume: To change, shape (x, z, y).
        ahead: To write: twice the new volume minus the old one.
        step: Its length.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    arrays = {"gradient": gradient, "hull": hull, "volume": volume, "ahead": ahead}
    device = checks.same_device(**arrays, dual=dual)
    checks.floats(3, **arrays)
    checks.same_shape(**arrays)
    checks.floats(4, dual=dual)
    checks.shape((3, *volume.shape), dual=dual)
    launch(lower_kernel, volume.shape, [gradient, dual, hull, step], [volume, ahead], device)


def raise_views(dual: wp.array, rendered: wp.array, wanted: wp.array, *, step: float) -> wp.array:
    """Take a dual step of the squared difference of views, in place: (p + s (B v - i)) / (1 + s / 2)."""
    return elementwise(raise_views_kernel, [rendered, wanted, step], dual)

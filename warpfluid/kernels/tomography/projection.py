"""Ray casting B of an emissive volume at many angles, and its exact transpose (Eq. 1).

The view at angle t sees voxel (x, z) at u = x cos t + z sin t, the origin in the middle of the box, which is as wide
and deep as the images are wide. The volume may be a part of the box that begins at a corner. Both directions gather.
``box``: a voxel's footprint is a box of width m = max(|cos t|, |sin t|) against unit bins. Along the axis that the
ray crosses faster, boxes of one row tile the detector without gaps, so a bin takes one to three voxels of a row and
a voxel gives one or two bins exactly its value. ``joseph``: linear interpolation along the row, 1/m long (Joseph 1982).
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch, run_count

wp.set_module_options({"enable_backward": False})

FOOTPRINTS = {"box": 0, "joseph": 1}

RAY_SUM = (
    """
    const int nx = volume.shape[0], nz = volume.shape[1], heights = volume.shape[2], width = images.shape[1];"""
    + RUN_OF_HEIGHTS
    + """
    const double middle = 0.5 * (width - 1), c = direction[0], s = direction[1];
    const bool along_z = wp::abs(c) >= wp::abs(s);           // rows follow z, taps step along x
    const double fast = along_z ? c : s, slope = (along_z ? s : c) / fast;
    const int taps = along_z ? nx : nz, first_tap = corner[along_z ? 0 : 1], first_row = corner[along_z ? 1 : 0];
    const float reach = (float)(1.0 / wp::abs(fast));
    const double low_at_middle = (u - middle) / fast + middle - first_tap + (footprint ? 0.0 : 0.5 - 0.5 * reach);
    const size_t row_stride = (size_t)heights * (along_z ? 1 : nz), tap_stride = (size_t)heights * (along_z ? nz : 1);
    const float* base = volume.data + y;
    float sum[RUN] = {};
    for (int k = span[0]; k < span[1]; ++k) {
        const double low = low_at_middle - (k + first_row - middle) * slope;
        const int first = (int)wp::floor(low);
        if (first < -2 || first >= taps) continue;
        const float start = (float)(low - first), end = start + reach;
        float w0 = footprint ? (1.0f - start) * reach : wp::min(end, 1.0f) - start;
        float w1 = footprint ? start * reach : wp::clamp(end - 1.0f, 0.0f, 1.0f);
        float w2 = footprint ? 0.0f : wp::max(end - 2.0f, 0.0f);
        if (first < 0) w0 = 0.0f;
        if (first < -1 || first + 1 >= taps) w1 = 0.0f;
        if (first + 2 >= taps) w2 = 0.0f;
        const float* row = base + k * row_stride;
        const float* r0 = row + wp::max(first, 0) * tap_stride;
        const float* r1 = row + wp::clamp(first + 1, 0, taps - 1) * tap_stride;
        const float* r2 = row + wp::min(first + 2, taps - 1) * tap_stride;
        if (count < RUN)
            for (int l = 0; l < count; ++l) sum[l] += w0 * r0[l] + w1 * r1[l] + w2 * r2[l];
        else if (w2 > 0.0f)
            for (int l = 0; l < RUN; ++l) sum[l] += w0 * r0[l] + w1 * r1[l] + w2 * r2[l];
        else
            for (int l = 0; l < RUN; ++l) sum[l] += w0 * r0[l] + w1 * r1[l];
    }
    float* out = images.data + ((size_t)a * width + u) * heights + y;
    for (int l = 0; l < count; ++l) out[l] = sum[l];
"""
)

VOXEL_SUM = (
    """
    const int nz = volume.shape[1], heights = volume.shape[2], width = images.shape[1];"""
    + RUN_OF_HEIGHTS
    + """
    const double middle = 0.5 * (width - 1);
    const double x_from_middle = x + corner[0] - middle, z_from_middle = z + corner[1] - middle;
    float sum[RUN] = {};
    const int angles = occupied ? images.shape[0] : 0;
    for (int a = 0; a < angles; ++a) {
        const float m = directions.data[a][2], per_m = directions.data[a][3];
        const double q = x_from_middle * directions.data[a][0] + z_from_middle * directions.data[a][1] + middle;
        const double low = footprint ? q : q - 0.5 * m + 0.5;
        const int first = (int)wp::floor(low);
        const float start = (float)(low - first);
        float near = footprint ? (1.0f - start * per_m) * per_m : wp::min((1.0f - start) * per_m, 1.0f);
        float far = footprint ? (1.0f - (1.0f - start) * per_m) * per_m : 1.0f - near;
        near = first < 0 || first >= width ? 0.0f : wp::max(near, 0.0f) * weights.data[a];
        far = first < -1 || first >= width - 1 ? 0.0f : wp::max(far, 0.0f) * weights.data[a];
        const float* bin = images.data + (size_t)a * width * heights + y;
        const float* b0 = bin + (size_t)wp::clamp(first, 0, width - 1) * heights;
        const float* b1 = bin + (size_t)wp::clamp(first + 1, 0, width - 1) * heights;
        if (count < RUN)
            for (int l = 0; l < count; ++l) sum[l] += near * b0[l] + far * b1[l];
        else
            for (int l = 0; l < RUN; ++l) sum[l] += near * b0[l] + far * b1[l];
    }
    const size_t voxel = ((size_t)x * nz + z) * heights + y;
    for (int l = 0; l < count; ++l) volume.data[voxel + l] = sum[l] * hull.data[voxel + l];
"""
)


@wp.func_native(snippet=RAY_SUM)
def ray_sum(
    volume: wp.array3d[float],
    direction: wp.vec4,
    span: wp.vec2i,
    corner: wp.vec2i,
    footprint: int,
    a: int,
    u: int,
    block: int,
    images: wp.array3d[float],
):
    """Add up the voxels along a ray."""


@wp.func_native(snippet=VOXEL_SUM)
def voxel_sum(
    images: wp.array3d[float],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    hull: wp.array3d[float],
    occupied: bool,
    corner: wp.vec2i,
    footprint: int,
    x: int,
    z: int,
    block: int,
    volume: wp.array3d[float],
):
    """Add up the pixels that see a voxel."""


@wp.kernel
def project_kernel(
    first_row: int,
    first_block: int,
    volume: wp.array3d[float],
    directions: wp.array[wp.vec4],
    spans: wp.array3d[wp.vec2i],
    corner: wp.vec2i,
    footprint: int,
    images: wp.array3d[float],
):
    """Add up the voxels along one ray, for a run of heights."""
    i, u, j = wp.tid()
    a = first_row + i
    block = first_block + j
    ray_sum(volume, directions[a], spans[a, u, block], corner, footprint, a, u, block, images)


@wp.kernel
def backproject_kernel(
    first_row: int,
    first_block: int,
    images: wp.array3d[float],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    hull: wp.array3d[float],
    occupied: wp.array3d[wp.uint8],
    corner: wp.vec2i,
    footprint: int,
    volume: wp.array3d[float],
):
    """Add up the pixels that see one voxel, for a run of heights."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    lit = occupied[x, z, block] > wp.uint8(0)
    voxel_sum(images, directions, weights, hull, lit, corner, footprint, x, z, block, volume)


@wp.kernel
def span_kernel(
    first_row: int,
    first_block: int,
    occupied: wp.array3d[wp.uint8],
    directions: wp.array[wp.vec4],
    corner: wp.vec2i,
    width: int,
    spans: wp.array3d[wp.vec2i],
):
    """Find the rows between which a ray meets the hull."""
    i, u, j = wp.tid()
    a = first_row + i
    block = first_block + j
    middle = 0.5 * float(width - 1)
    c = directions[a][0]
    s = directions[a][1]
    along_z = wp.abs(c) >= wp.abs(s)
    fast = wp.where(along_z, c, s)
    slope = wp.where(along_z, s, c) / fast
    rows = wp.where(along_z, occupied.shape[1], occupied.shape[0])
    taps = wp.where(along_z, occupied.shape[0], occupied.shape[1])
    first_row = wp.where(along_z, corner[1], corner[0])
    first_tap = wp.where(along_z, corner[0], corner[1])
    begin = int(rows)
    end = int(0)
    for k in range(rows):
        centre = (float(u) - middle) / fast - (float(k + first_row) - middle) * slope + middle
        first = int(wp.floor(centre)) - 1 - first_tap
        for tap in range(wp.max(first, 0), wp.min(first + 4, taps)):
            lit = wp.uint8(0)
            if along_z:
                lit = occupied[tap, k, block]
            else:
                lit = occupied[k, tap, block]
            if lit > wp.uint8(0):
                begin = wp.min(begin, k)
                end = k + 1
    spans[a, u, block] = wp.vec2i(begin, end)


def ray_spans(
    directions: wp.array[wp.vec4],
    occupied: wp.array3d[wp.uint8],
    heights: int,
    *,
    width: int,
    corner: tuple[int, int] = (0, 0),
) -> wp.array3d[wp.vec2i]:
    """Return the rows [begin, end) between which each ray meets the hull, shape (angle, u, run of heights).

    Args:
        directions: cos t, sin t, m = max(|cos t|, |sin t|) and 1 / m of every angle.
        occupied: Which runs of heights hold a voxel of the hull, shape (x, z, run).
        heights: Heights of the volume.
        width: Width of the images and of the box.
        corner: Where in the box the volume begins (x, z).
    """
    device = checks.same_device(directions=directions, occupied=occupied)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.typed(wp.uint8, 3, occupied=occupied)
    count, runs = directions.shape[0], occupied.shape[2]
    checks.shape((*occupied.shape[:2], run_count(heights, device)), occupied=occupied)
    spans = wp.empty((count, width, runs), dtype=wp.vec2i, device=device)
    launch(span_kernel, (count, width, heights), [occupied, directions, wp.vec2i(corner), width], [spans], device)
    return spans


def project(
    volume: wp.array3d[float],
    directions: wp.array[wp.vec4],
    spans: wp.array3d[wp.vec2i],
    *,
    footprint: str,
    out: wp.array3d[float],
    corner: tuple[int, int] = (0, 0),
) -> wp.array3d[float]:
    """Cast rays through a volume: B v of Eq. 1.

    Args:
        volume: Shape (x, z, y), zero outside the hull that the spans were made for.
        directions: cos t, sin t, m and 1 / m of every angle.
        spans: Rows of the volume that each ray visits, from ``ray_spans``.
        footprint: ``box`` or ``joseph``.
        out: Images to write, shape (angle, u, v).
        corner: Where in the box the volume begins (x, z).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(volume=volume, directions=directions, spans=spans, out=out)
    checks.floats(3, volume=volume, out=out)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.typed(wp.vec2i, 3, spans=spans)
    count, width, heights = out.shape
    checks.shape((count,), directions=directions)
    checks.shape((*volume.shape[:2], heights), volume=volume)
    checks.shape((count, width, run_count(heights, device)), spans=spans)
    inputs = [volume, directions, spans, wp.vec2i(corner), FOOTPRINTS[footprint]]
    launch(project_kernel, out.shape, inputs, [out], device)
    return out


def backproject(
    images: wp.array3d[float],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    hull: wp.array3d[float],
    occupied: wp.array3d[wp.uint8],
    *,
    footprint: str,
    out: wp.array3d[float],
    corner: tuple[int, int] = (0, 0),
) -> wp.array3d[float]:
    """Give every voxel of the hull the pixels that see it: the exact transpose of ``project``.

    Args:
        images: Shape (angle, u, v).
        directions: cos t, sin t, m and 1 / m of every angle.
        weights: One factor an angle.
        hull: 1 inside and 0 outside, shape (x, z, y).
        occupied: Which runs of heights hold a voxel of the hull, shape (x, z, run).
        footprint: ``box`` or ``joseph``.
        out: Volume to write, shape (x, z, y).
        corner: Where in the box the volume begins (x, z).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    arrays = {
        "images": images,
        "directions": directions,
        "weights": weights,
        "hull": hull,
        "occupied": occupied,
    }
    device = checks.same_device(**arrays, out=out)
    checks.floats(3, images=images, hull=hull, out=out)
    checks.floats(1, weights=weights)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.typed(wp.uint8, 3, occupied=occupied)
    count, _, heights = images.shape
    checks.shape((*hull.shape[:2], heights), hull=hull, out=out)
    checks.shape((count,), directions=directions, weights=weights)
    checks.shape((*hull.shape[:2], run_count(heights, device)), occupied=occupied)
    inputs = [images, directions, weights, hull, occupied, wp.vec2i(corner), FOOTPRINTS[footprint]]
    launch(backproject_kernel, out.shape, inputs, [out], device)
    return out

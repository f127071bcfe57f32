"""How much of a distant light reaches each voxel, swept through the volume plane by plane.

A voxel sums what is on its way to the light up to ``DEPTH`` planes nearer, across the light's main axis, and multiplies
by what has come through to there, read linearly between four places that were done before. The cost is the same for
every voxel. Steps over several planes keep shadows sharp: their edges are about ``sqrt(n / DEPTH) / 2`` voxels wide
after n planes. What is interpolated is light, not optical depth, so that the shadow of a small dense thing becomes soft
with distance and not wide.
"""

import math
from collections.abc import Sequence

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch

wp.set_module_options({"enable_backward": False})

DEPTH = 8  # planes done at a time, and between two at which light is interpolated

TOWARDS_LIGHT = (
    """
    const int nx = extinction.shape[0], nz = extinction.shape[1], top = extinction.shape[2];
    const int heights = part_height;"""
    + RUN_OF_HEIGHTS
    + f"""
    enum {{ DEPTH = {DEPTH} }};"""
    + """
    const int bottom = part_bottom + y;  // of this run
    // adds weight * (value - zero) of the places j planes nearer to the light
    const auto gather = [&](const float* values, float zero, int j, float weight, float* sum) {
        const float at[3] = {j * step[0], j * step[1], j * step[2]};
        const int ix = (int)floorf(at[0]), iz = (int)floorf(at[1]), iy = (int)floorf(at[2]);
        const float a = at[0] - ix, b = at[1] - iz, c = at[2] - iy;
        for (int corner = 0; corner < 8; ++corner) {
            const int px = x + ix + (corner & 1), pz = z + iz + (corner >> 1 & 1), py = bottom + iy + (corner >> 2);
            const float w = weight * (corner & 1 ? a : 1.0f - a) * (corner & 2 ? b : 1.0f - b)
                * (corner & 4 ? c : 1.0f - c);
            if (w == 0.0f || px < 0 || pz < 0 || px >= nx || pz >= nz) continue;
            const float* from = values + ((size_t)px * nz + pz) * top;
            const int begin = py < 0 ? -py : 0, end = count < top - py ? count : top - py;
            for (int l = begin; l < end; ++l) sum[l] += w * (from[py + l] - zero);
        }
    };
    float depth[RUN] = {}, light[RUN];
    for (int l = 0; l < RUN; ++l) light[l] = 1.0f;
    for (int j = 0; j <= DEPTH; ++j) gather(extinction.data, 0.0f, j, j % DEPTH ? 1.0f : 0.5f, depth);
    gather(out.data, 1.0f, DEPTH, 1.0f, light);
    float* to = out.data + ((size_t)x * nz + z) * top + bottom;
    for (int l = 0; l < count; ++l) to[l] = light[l] * expf(-length * depth[l]);
"""
)


@wp.func_native(snippet=TOWARDS_LIGHT)
def look_to_light(
    extinction: wp.array3d[float],
    step: wp.vec3,
    length: float,
    part_bottom: int,
    part_height: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Follow the rays of a run of heights to places that are done already."""


@wp.kernel
def shadow_kernel(
    first_row: int,
    first_block: int,
    extinction: wp.array3d[float],
    axis: int,
    first: int,
    step: wp.vec3,
    length: float,
    part_bottom: int,
    part_height: int,
    out: wp.array3d[float],
):
    """Find the light in some planes from ``first`` on; rows and columns are z and x, x and z, or x and z."""
    i, j, k = wp.tid()
    x = first_row + i
    z = j
    if axis == 0:
        z = first_row + i
        x = first + j
    elif axis == 1:
        z = first + j
    look_to_light(extinction, step, length, part_bottom, part_height, x, z, first_block + k, out)


def shadow(
    extinction: wp.array3d[float],
    direction: Sequence[float],
    *,
    spacing: float = 1.0,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Return the share of a distant light that comes through to each voxel, ``exp(-sum)`` on the way to the light.

    Args:
        extinction: 0 beyond the border, shape (x, z, y) .
        direction: To the light, components (x, z, y), of any length.
        spacing: Edge of a voxel, in the unit of length that the extinction is said for.
        out: Array to write, never ``extinction`` itself; a new one when omitted.

    Returns:
        Transmittance from 0 to 1, shape of ``extinction``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the direction is none.
    """
    out = wp.empty_like(extinction) if out is None else out
    device = checks.same_device(extinction=extinction, out=out)
    checks.floats(3, extinction=extinction, out=out)
    checks.same_shape(extinction=extinction, out=out)
    norm = math.hypot(*direction)
    if not spacing > 0:
        raise ValueError(f"spacing is {spacing}, expected a length above 0")
    if len(direction) != 3 or not 0 < norm < math.inf:
        raise ValueError(f"direction is {tuple(direction)}, expected three finite numbers (x, z, y) that are not all 0")
    axis = max(range(3), key=lambda n: abs(direction[n]))
    step = wp.vec3(*(float(part) / abs(direction[axis]) for part in direction))
    count, rising = extinction.shape[axis], direction[axis] > 0
    for begin in range(0, count, DEPTH):
        planes = min(DEPTH, count - begin)
        first = count - begin - planes if rising else begin
        shape, bottom = _part(extinction.shape, axis, first, planes)
        inputs = [extinction, axis, first, step, spacing * norm / abs(direction[axis]), bottom, shape[2]]
        launch(shadow_kernel, shape, inputs, [out], device)
    return out


def _part(shape, axis: int, first: int, planes: int) -> tuple[tuple[int, int, int], int]:
    """Return rows, columns and heights of some planes, and the lowest height."""
    x, z, y = shape
    if axis == 2:
        return (x, z, planes), first
    return (z if axis == 0 else x, planes, y), 0

"""A periodic lattice, joined smoothly by cubic B-splines: how a few nodes a wave become a field of voxels."""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch

wp.set_module_options({"enable_backward": False})

# A column's run of heights needs a few nodes of the lattice: 16 columns of it are mixed to one, from which each height
# takes four nodes.
CLOSEST = 0.8  # [voxel] between nodes, so that those of a run fit into the array ``line``
SPLINE_RUN = (
    """
    const int nx = tile.shape[0], nz = tile.shape[1], ny = tile.shape[2], heights = out.shape[2];"""
    + RUN_OF_HEIGHTS
    + """
    enum { NODES = RUN + RUN / 4 + 6 };
    auto spline = [](float t, float* w) {
        const float r = 1.0f - t;
        w[0] = r * r * r / 6.0f;
        w[1] = (4.0f - 6.0f * t * t + 3.0f * t * t * t) / 6.0f;
        w[2] = (4.0f - 6.0f * r * r + 3.0f * r * r * r) / 6.0f;
        w[3] = t * t * t / 6.0f;
    };
    const float px = first[0] + x * nodes_a_voxel[0], pz = first[1] + z * nodes_a_voxel[1];
    const int ix = (int)floorf(px) - 1, iz = (int)floorf(pz) - 1, iy = (int)floorf(first[2] + y * nodes_a_voxel[2]) - 1;
    const int nodes = (int)floorf(first[2] + (y + count - 1) * nodes_a_voxel[2]) + 3 - iy;
    float wx[4], wz[4], line[NODES] = {};
    spline(px - (ix + 1), wx);
    spline(pz - (iz + 1), wz);
    for (int p = 0; p < 4; ++p)
        for (int q = 0; q < 4; ++q) {
            const int a = ((ix + p) % nx + nx) % nx, b = ((iz + q) % nz + nz) % nz;
            const float weight = gain * wx[p] * wz[q];
            const float* from = tile.data + ((size_t)a * nz + b) * ny;
            int node = (iy % ny + ny) % ny;
            for (int done = 0; done < nodes; node = 0) {
                const int span = ny - node < nodes - done ? ny - node : nodes - done;
                for (int l = 0; l < span; ++l) line[done + l] += weight * from[node + l];
                done += span;
            }
        }
    float* to = out.data + ((size_t)x * out.shape[1] + z) * heights + y;
    for (int l = 0; l < count; ++l) {
        const float py = first[2] + (y + l) * nodes_a_voxel[2], below = floorf(py);
        const float* at = line + ((int)below - 1 - iy);
        float wy[4];
        spline(py - below, wy);
        const float sum = wy[0] * at[0] + wy[1] * at[1] + wy[2] * at[2] + wy[3] * at[3];
        to[l] += sum;
    }
"""
)


@wp.func_native(snippet=SPLINE_RUN)
def spline_run(
    tile: wp.array3d[float],
    first: wp.vec3,
    nodes_a_voxel: wp.vec3,
    gain: float,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Interpolate a periodic lattice along a run of heights."""


@wp.kernel
def lattice_kernel(
    first_row: int,
    first_block: int,
    tile: wp.array3d[float],
    first: wp.vec3,
    nodes_a_voxel: wp.vec3,
    gain: float,
    out: wp.array3d[float],
):
    """Add a periodic lattice to a run of heights."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    spline_run(tile, first, nodes_a_voxel, gain, x, z, block, out)


def interpolate(
    tile: wp.array3d[float],
    *,
    first: tuple[float, float, float],
    spacing: tuple[float, float, float],
    gain: float,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Add a periodic lattice to an array, joined smoothly by cubic B-splines.

    Args:
        tile: Coefficients of the splines, one period of the lattice, shape (nodes x, nodes z, nodes y).
        first: Where the array's first element lies on the lattice, (x, z, y) [node].
        spacing: Of the nodes, ``CLOSEST`` at least [elements of the array].
        gain: Factor.
        out: What is added to, any shape (x, z, y).

    Returns:
        ``out``.

    Raises:
        ValueError: If types or devices do not fit or nodes lie too close.
    """
    device = checks.same_device(tile=tile, out=out)
    checks.floats(3, tile=tile, out=out)
    if min(spacing) < CLOSEST * (1 - 1e-4):
        raise ValueError(f"spacing is {spacing}, expected {CLOSEST} or more between the nodes of a lattice")
    nodes_a_voxel = wp.vec3(*(1 / width for width in spacing))
    launch(lattice_kernel, out.shape, [tile, wp.vec3(*first), nodes_a_voxel, gain], [out], device)
    return out

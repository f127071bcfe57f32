"""Eddies finer than the grid (wavelet turbulence: Kim, Thuerey, James and Gross 2008).

A tile of random waves is laid over a fluid by texture coordinates that it carries along. As a potential, as strong as
the eddies are that the grid just resolves, it has a curl: small eddies that come with the large ones.
"""

import math

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.fluid.faces import launch_run
from warpfluid.kernels.launch import elementwise
from warpfluid.kernels.sampling import coarse_place, trilinear

wp.set_module_options({"enable_backward": False})


@wp.func
def wrapped(i: int, n: int) -> int:
    """Return a node's place in a tile that repeats."""
    return (i % n + n) % n


@wp.func
def from_tile(tile: wp.array3d[wp.vec3], at: wp.vec3) -> wp.vec3:
    """Interpolate a tile linearly at a place [node]."""
    i, j, k = int(wp.floor(at[0])), int(wp.floor(at[1])), int(wp.floor(at[2]))
    a, b, c = at[0] - float(i), at[1] - float(j), at[2] - float(k)
    x0, z0, y0 = wrapped(i, tile.shape[0]), wrapped(j, tile.shape[1]), wrapped(k, tile.shape[2])
    x1 = wp.where(x0 + 1 < tile.shape[0], x0 + 1, 0)
    z1 = wp.where(z0 + 1 < tile.shape[1], z0 + 1, 0)
    y1 = wp.where(y0 + 1 < tile.shape[2], y0 + 1, 0)
    near = wp.lerp(wp.lerp(tile[x0, z0, y0], tile[x0, z0, y1], c), wp.lerp(tile[x0, z1, y0], tile[x0, z1, y1], c), b)
    far = wp.lerp(wp.lerp(tile[x1, z0, y0], tile[x1, z0, y1], c), wp.lerp(tile[x1, z1, y0], tile[x1, z1, y1], c), b)
    return wp.lerp(near, far, a)


@wp.kernel
def lay_tile_kernel(
    first_row: int,
    first_block: int,
    tile: wp.array3d[wp.vec3],
    size: wp.array3d[float],
    away_x: wp.array3d[float],
    away_z: wp.array3d[float],
    away_y: wp.array3d[float],
    offset: wp.vec3,
    nodes_a_voxel: float,
    gain: float,
    factor: int,
    run: int,
    out: wp.array3d[wp.vec3],
):
    """Look up the tile where a fine voxel's fluid came from; nothing is done where there are no eddies."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        here = coarse_place(x, z, y, factor)
        strength = gain * trilinear(size, here)
        if strength > 0.0:
            away = wp.vec3(trilinear(away_x, here), trilinear(away_z, here), trilinear(away_y, here))
            out[x, z, y] = out[x, z, y] + strength * from_tile(tile, offset + nodes_a_voxel * (here - away))


@wp.kernel
def limit_reach_kernel(
    squares: wp.array[float], cover: wp.array[float], faint: float, gain: float, limit: float, out: wp.array[float]
):
    """Turn the square of a speed into how far it carries, ever less beyond a limit, where there is fluid."""
    i = wp.tid()
    reach = gain * wp.sqrt(wp.max(squares[i], 0.0))
    share = wp.clamp((cover[i] - faint) / (1.0 - faint), 0.0, 1.0)
    out[i] = share * reach / (1.0 + reach / limit)


@wp.kernel
def curl_kernel(
    first_row: int, first_block: int, potential: wp.array3d[wp.vec3], scale: float, run: int, out: wp.array3d[wp.vec3]
):
    """Take the curl by central differences; beyond the border the potential goes on as it is there."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    x0, x1 = wp.max(x - 1, 0), wp.min(x + 1, out.shape[0] - 1)
    z0, z1 = wp.max(z - 1, 0), wp.min(z + 1, out.shape[1] - 1)
    for y in range(begin, wp.min(begin + run, out.shape[2])):
        y0, y1 = wp.max(y - 1, 0), wp.min(y + 1, out.shape[2] - 1)
        by_x = potential[x1, z, y] - potential[x0, z, y]
        by_z = potential[x, z1, y] - potential[x, z0, y]
        by_y = potential[x, z, y1] - potential[x, z, y0]
        out[x, z, y] = scale * wp.vec3(by_z[2] - by_y[1], by_y[0] - by_x[2], by_x[1] - by_z[0])


def limit_reach(
    squares: wp.array3d[float],
    cover: wp.array3d[float],
    *,
    faint: float,
    gain: float,
    limit: float,
    out: wp.array3d[float],
) -> wp.array3d[float]:
    """Return how far eddies carry: ``gain`` times their speed where that is little, never farther than a limit.

    Args:
        squares: Of their speed, shape (x, z, y).
        cover: Where there is fluid, 0 to 1; more counts as 1.
        faint: Cover that still counts as none.
        gain: How long they carry.
        limit: [voxel].
        out: Array to write; it may be one of the others.

    Returns:
        ``out`` [voxel].

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    return elementwise(limit_reach_kernel, [squares, cover, faint, gain, limit], out)


def lay_tile(
    tile: wp.array3d[wp.vec3],
    size: wp.array3d[float],
    away_x: wp.array3d[float],
    away_z: wp.array3d[float],
    away_y: wp.array3d[float],
    *,
    offset: tuple[float, float, float],
    nodes_a_voxel: float,
    gain: float,
    factor: int,
    out: wp.array3d[wp.vec3],
) -> wp.array3d[wp.vec3]:
    """Add a tile to a potential on a finer grid, moved as far as the fluid has carried it.

    Args:
        tile: Three components, one period, several nodes a wave, shape (nodes x, nodes z, nodes y).
        size: What it is multiplied by, on the coarse grid, shape (x, z, y), 0 where nothing is added.
        away_x: How far the fluid has carried what is in a voxel, along x, shape of ``size`` [voxel].
        away_z: Along z.
        away_y: Along y.
        offset: Which part of the tile lies at the coarse voxel (0, 0, 0) [node].
        nodes_a_voxel: Nodes of the tile in a coarse voxel.
        gain: Factor.
        factor: Fine voxels in a coarse one, along each axis.
        out: What is added to, ``factor`` times as large along each axis.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit or there are no nodes in a voxel.
    """
    coarse = {"size": size, "away_x": away_x, "away_z": away_z, "away_y": away_y}
    checks.same_device(tile=tile, out=out, **coarse)
    checks.typed(wp.vec3, 3, tile=tile, out=out)
    checks.floats(3, **coarse)
    checks.same_shape(**coarse)
    checks.shape(tuple(factor * n for n in size.shape), out=out)
    if not (nodes_a_voxel > 0 and math.isfinite(nodes_a_voxel)):
        raise ValueError(f"nodes_a_voxel is {nodes_a_voxel}, expected a number above 0")
    launch_run(lay_tile_kernel, [tile, *coarse.values(), wp.vec3(*offset), nodes_a_voxel, gain, factor], out)
    return out


def curl(potential: wp.array3d[wp.vec3], *, scale: float, out: wp.array3d[wp.vec3]) -> wp.array3d[wp.vec3]:
    """Return the curl of a potential in voxels' centres: a flow without divergence, by central differences.

    Args:
        potential: Components (x, z, y), shape (x, z, y).
        scale: Factor; 0.5 for differences a voxel.
        out: Array to write, never ``potential`` itself.

    Returns:
        ``out``; it turns as (x, z, y), which is left-handed, has it.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(potential=potential, out=out)
    checks.typed(wp.vec3, 3, potential=potential, out=out)
    checks.same_shape(potential=potential, out=out)
    if out is potential:
        raise ValueError("out is the potential that is read: pass another array")
    launch_run(curl_kernel, [potential, scale], out)
    return out

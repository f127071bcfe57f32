"""A turbulent force: the curl of random waves, which stirs without pressing anything together (Bridson et al. 2007).

The waves are a potential on the edges of the voxels. The curl takes differences around each face, and over any voxel
these cancel, so that the force has no divergence for the pressure step to undo.
"""

import math

import numpy as np
import warp as wp

from warpfluid.kernels.faces import check_faces, launch_run, on_wall
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.random_waves import curl_size, draw_tiles, lay_lattice, make_waves
from warpfluid.kernels.sides import SIX, WRAP

wp.set_module_options({"enable_backward": False})

FINEST = 0.25  # [cycles/voxel]: a wave of four voxels; finer ones the grid does not carry
FADE = 2.0 ** (-5.0 / 6.0)  # of the strength, from one octave to the next
HASTE = 2.0 ** (2.0 / 3.0)  # smaller eddies change faster (Kolmogorov 1941)

# A column's run of heights needs a few nodes of the lattice: 16 columns of it are mixed to one, from which each height
# takes four nodes. Nodes are at least 0.8 voxels apart.
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
        to[l] = add ? to[l] + sum : sum;
    }
"""
)


@wp.func_native(snippet=SPLINE_RUN)
def spline_run(
    tile: wp.array3d[float],
    first: wp.vec3,
    nodes_a_voxel: wp.vec3,
    gain: float,
    add: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Interpolate a periodic lattice along a run of heights."""


@wp.kernel
def potential_kernel(
    first_row: int,
    first_block: int,
    tile: wp.array3d[float],
    first: wp.vec3,
    nodes_a_voxel: wp.vec3,
    gain: float,
    add: int,
    out: wp.array3d[float],
):
    """Write one component of an octave's waves to the edges along its axis, or add it."""
    i, z, j = wp.tid()
    x = first_row + i
    block = first_block + j
    spline_run(tile, first, nodes_a_voxel, gain, add, x, z, block, out)


@wp.func
def cell_across(i: int, n: int, wraps: bool) -> int:
    """Return the voxel at an index one beyond the border at most: the one across, or the last one."""
    if wraps:
        return wp.where(i < 0, i + n, wp.where(i >= n, i - n, i))
    return wp.clamp(i, 0, n - 1)


@wp.kernel
def mask_kernel(
    first_row: int,
    first_block: int,
    mask: wp.array3d[float],
    axis: int,
    sides: SIX,
    run: int,
    potential: wp.array3d[float],
):
    """Multiply an edge by the least of the voxels around it, so that a voxel of 0 has no force on any face."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    for y in range(begin, wp.min(begin + run, potential.shape[2])):
        least = float(1.0)
        for corner in range(4):
            b = corner & 1
            c = corner >> 1
            i = x - wp.where(axis == 0, 0, b)
            j = z - wp.where(axis == 1, 0, wp.where(axis == 0, b, c))
            k = y - wp.where(axis == 2, 0, c)
            i = cell_across(i, mask.shape[0], sides[0] == WRAP)
            j = cell_across(j, mask.shape[1], sides[2] == WRAP)
            k = cell_across(k, mask.shape[2], sides[4] == WRAP)
            least = wp.min(least, mask[i, j, k])
        potential[x, z, y] = least * potential[x, z, y]


@wp.func
def edge(potential: wp.array3d[float], x: int, z: int, y: int, cells: wp.vec3i, sides: SIX) -> float:
    """Fetch the potential of an edge; the last edge of a wrapped axis is its first."""
    i = wp.where(x == cells[0] and sides[0] == WRAP, 0, x)
    j = wp.where(z == cells[1] and sides[2] == WRAP, 0, z)
    k = wp.where(y == cells[2] and sides[4] == WRAP, 0, y)
    return potential[i, j, k]


@wp.kernel
def curl_kernel(
    first_row: int,
    first_block: int,
    potential_b: wp.array3d[float],
    potential_c: wp.array3d[float],
    axis: int,
    cells: wp.vec3i,
    sides: SIX,
    run: int,
    velocity: wp.array3d[float],
):
    """Add the circulation around a face; b and c are the axes after the face's own, in turn."""
    row, z, block = wp.tid()
    x = first_row + row
    begin = (first_block + block) * run
    bx = wp.where(axis == 2, 1, 0)
    bz = wp.where(axis == 0, 1, 0)
    by = wp.where(axis == 1, 1, 0)
    for y in range(begin, wp.min(begin + run, velocity.shape[2])):
        if not on_wall(axis, x, z, y, cells, sides):
            along = edge(potential_c, x + bx, z + bz, y + by, cells, sides) - edge(potential_c, x, z, y, cells, sides)
            back = edge(potential_b, x + by, z + bx, y + bz, cells, sides) - edge(potential_b, x, z, y, cells, sides)
            velocity[x, z, y] = velocity[x, z, y] + (along - back)


def add_turbulence(
    velocity_x: wp.array3d[float],
    velocity_z: wp.array3d[float],
    velocity_y: wp.array3d[float],
    *,
    strength: float,
    frequency: float,
    phase: float,
    octaves: int,
    seed: int,
    sides: SIX,
    time_step: float,
    mask: wp.array3d[float] | None = None,
) -> None:
    """Stir a fluid with eddies of several sizes, in place.

    The pattern depends on the place in waves, measured from the middle of the floor: the same at any resolution, if
    ``frequency`` follows it. Each octave has half the wavelength of the one before, 2^(-5/6) of its strength
    and changes 2^(2/3) times as fast. Octaves finer than ``FINEST`` are left out; the first is never finer than it.

    Args:
        velocity_x: [voxel/s], shape (nx + 1, nz, ny).
        velocity_z: Shape (nx, nz + 1, ny).
        velocity_y: Shape (nx, nz, ny + 1).
        strength: Root mean square of the acceleration where the mask is 1 [voxel/s^2].
        frequency: Of the largest eddies [cycles/voxel].
        phase: How often the pattern has become another one: speed [1/s] times seconds, or its integral.
        octaves: 1 to 6.
        seed: Of the pattern, >= 0.
        sides: What the box's six sides are; the pattern repeats where they wrap, faces on closed ones stay as they are.
        time_step: [s].
        mask: Where it stirs, 0 to 1, shape (nx, nz, ny). It multiplies the potential: voxels of 0 get no force, and the
            force stays free of divergence. The rim of a mask that falls within less than half a wave is pushed along it
            more strongly; blur the mask.

    Raises:
        ValueError: If shapes, types or devices do not fit or numbers are out of range.
    """
    masks = {} if mask is None else {"mask": mask}
    cells, _ = check_faces(velocity_x, velocity_z, velocity_y, **masks)
    _check_numbers(frequency, octaves, seed)
    if strength * time_step == 0:
        return
    potentials = _potentials(cells, sides, strength * time_step, frequency, phase, octaves, seed, velocity_x.device)
    if mask is not None:
        for axis, potential in enumerate(potentials):
            launch_run(mask_kernel, [mask, axis, sides], potential)
    for axis, velocity in enumerate((velocity_x, velocity_z, velocity_y)):
        around = [potentials[(axis + 1) % 3], potentials[(axis + 2) % 3]]
        launch_run(curl_kernel, [*around, axis, wp.vec3i(*cells), sides], velocity)


def _potentials(
    cells: tuple[int, int, int],
    sides: SIX,
    strength: float,
    frequency: float,
    phase: float,
    octaves: int,
    seed: int,
    device: wp.Device,
) -> list[wp.array]:
    """Return the waves of all octaves on the edges along x, z and y."""
    shapes = [tuple(n + (k != axis) for k, n in enumerate(cells)) for axis in range(3)]
    potentials = [wp.zeros(shape, dtype=float, device=device) for shape in shapes]
    wraps = tuple(sides[2 * axis] == WRAP for axis in range(3))
    frequencies = [frequency * 2**octave for octave in range(octaves)]
    frequencies = [f for f in frequencies if f <= FINEST] or [FINEST]
    total = math.hypot(*(FADE**octave for octave in range(len(frequencies))))
    for octave, f in enumerate(frequencies):
        lattice = lay_lattice(cells, f, wraps)
        waves = make_waves(lattice.nodes, lattice.stretch(f), seed, octave)
        size = curl_size(waves, f)
        if size == 0:
            continue  # no such wave fits into a box that wraps
        tiles = draw_tiles(lattice.nodes, waves, phase * HASTE**octave)
        for axis, potential in enumerate(potentials):
            shift = np.where(np.arange(3) == axis, 0.0, 0.5)
            middle = np.array([cells[0] / 2 - 0.5, cells[1] / 2 - 0.5, -0.5])
            first = -(shift + middle) / lattice.spacing
            inputs = [wp.array(tiles[axis], dtype=float, device=device), wp.vec3(*first)]
            inputs += [
                wp.vec3(*(1 / np.array(lattice.spacing))),
                strength * FADE**octave / total / size,
                int(octave > 0),
            ]
            launch(potential_kernel, potential.shape, inputs, [potential], device)
    return potentials


def _check_numbers(frequency: float, octaves: int, seed: int) -> None:
    if not (frequency > 0 and math.isfinite(frequency)):
        raise ValueError(f"frequency is {frequency}, expected a number above 0, in cycles/voxel")
    if octaves not in range(1, 7):
        raise ValueError(f"octaves is {octaves}, expected 1 to 6")
    if seed < 0:
        raise ValueError(f"seed is {seed}, expected a whole number >= 0")

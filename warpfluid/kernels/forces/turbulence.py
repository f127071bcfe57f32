"""A turbulent force: the curl of random waves, which stirs without pressing anything together (Bridson et al. 2007).

The waves are a potential on the edges of the voxels. The curl takes differences around each face, and over any voxel
these cancel, so that the force has no divergence for the pressure step to undo.
"""

import functools
import math

import numpy as np
import warp as wp

from warpfluid.kernels.fluid.faces import check_faces
from warpfluid.kernels.forces.edges import add_curl, mask_edges
from warpfluid.kernels.forces.lattice import interpolate
from warpfluid.kernels.forces.random_waves import Lattice, Waves, curl_size, draw_tiles, lay_lattice, make_waves, window
from warpfluid.kernels.sides import SIX, WRAP

FINEST = 0.25  # [cycles/voxel]: a wave of four voxels; finer ones the grid does not carry
FADE = 2.0 ** (-5.0 / 6.0)  # of the strength, from one octave to the next
HASTE = 2.0 ** (2.0 / 3.0)  # smaller eddies change faster (Kolmogorov 1941)


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
        mask: Where it stirs, 0 to 1, shape (nx, nz, ny). It multiplies the potential: voxels of 0 get no force, and
            nothing is pressed together. A sharp rim is pushed along several times as strongly; blurred by a twelfth of
            a wave it is not.

    Raises:
        ValueError: If shapes, types or devices do not fit or numbers are out of range.
    """
    masks = {} if mask is None else {"mask": mask}
    cells, _ = check_faces(velocity_x, velocity_z, velocity_y, **masks)
    _check_numbers(frequency, octaves, seed)
    if strength * time_step == 0:
        return
    edges = _potentials(cells, sides, strength * time_step, frequency, phase, octaves, seed, velocity_x.device)
    if mask is not None:
        mask_edges(*edges, mask, sides=sides)
    add_curl(velocity_x, velocity_z, velocity_y, *edges, sides=sides)


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
        lattice, waves, size = _octave(cells, f, wraps, seed, octave)
        if size == 0:
            continue  # no such wave fits into a box that wraps
        corner = -np.array([cells[0] / 2, cells[1] / 2, 0.0]) / lattice.spacing
        windows = [window(*of) for of in zip(corner, lattice.spacing, np.add(cells, 2), lattice.nodes, strict=True)]
        begin, wanted = zip(*windows, strict=True)
        tiles = draw_tiles(lattice.nodes, waves, phase * HASTE**octave, wanted)
        for axis, potential in enumerate(potentials):
            shift = np.where(np.arange(3) == axis, 0.5, 0.0)
            first = corner + shift / lattice.spacing - begin
            tile = wp.array(tiles[axis], dtype=float, device=device)
            gain = strength * FADE**octave / total / size
            interpolate(tile, first=first, spacing=lattice.spacing, gain=gain, out=potential)
    return potentials


@functools.lru_cache(maxsize=8)
def _octave(
    cells: tuple[int, int, int], frequency: float, wraps: tuple[bool, bool, bool], seed: int, octave: int
) -> tuple[Lattice, Waves, float]:
    """Return the lattice of an octave, its waves, and the size of their curl."""
    lattice = lay_lattice(cells, frequency, wraps)
    waves = make_waves(lattice.nodes, lattice.stretch(frequency), seed, octave)
    return lattice, waves, curl_size(waves, frequency)


def _check_numbers(frequency: float, octaves: int, seed: int) -> None:
    if not (frequency > 0 and math.isfinite(frequency)):
        raise ValueError(f"frequency is {frequency}, expected a number above 0, in cycles/voxel")
    if octaves not in range(1, 7):
        raise ValueError(f"octaves is {octaves}, expected 1 to 6")
    if seed < 0:
        raise ValueError(f"seed is {seed}, expected a whole number >= 0")

"""Random walks that add and take quanta of light (Gregson et al. 2012): one sweep of many chains.

The energy is the weighted squared difference of rendered and measured views plus ``sad`` times the sum of absolute
differences between neighbours. A chain proposes a box of 1, 2 or 4 voxels a side near its place, works out what a
quantum more or less there does to the energy, and applies whichever lowers it, or by Metropolis's rule what raises it
a little. Chains are bound to slabs of ``SLAB`` heights, which share no pixel, so one thread walks a slab with all its
chains and owns what it writes; of neighbouring slabs only one moves at a time. Random numbers are counted, not drawn
from a state: hashes of seed, sweep, chain and step. So a seed gives the same bits for any number of threads.
"""

import numpy as np
import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import each
from warpfluid.kernels.tomography.projection import FOOTPRINTS
from warpfluid.kernels.tomography.quanta import DRAW, SHADE, WEIGH

wp.set_module_options({"enable_backward": False})

SLAB = 4  # heights

WALK = (
    """
    const int heights = volume.shape[0], chains = places.shape[0], bottom = wp::max(begin, 0);
    const int top = wp::min(begin + SLAB_HEIGHTS, heights), high = top - bottom, steps = counts.data[slab];
    const int last = wp::min(chains, first_chain + chains_a_slab);
    int applied = 0;"""
    + SHADE
    + WEIGH
    + DRAW
    + """
    const auto side = [](unsigned bits) { return bits % 8 < 6 ? 1 : bits % 8 < 7 ? 2 : 4; };
    for (int chain = first_chain; chain < last && high > 0; ++chain) {
        int* kept = places.data + 3 * (size_t)chain;
        int here[3], one[3] = {1, 1, 1}, ends[3] = {nx, nz, high};
        for (int i = 0; i < 3; ++i) here[i] = wp::clamp(kept[i], 0, ends[i] - 1) + (i == 2 ? bottom : 0);
        float ignored, now = weigh(here, one, ignored);
        for (int step = 0; step < steps; ++step) {
            const unsigned long long a = draw(chain, step, 0), b = draw(chain, step, 1);
            const unsigned chance = (unsigned)(b >> 32);
            int size[3] = {side((unsigned)a), side((unsigned)a >> 3), side((unsigned)a >> 6)}, there[3];
            size[0] = wp::min(size[0], nx);
            size[1] = wp::min(size[1], nz);
            size[2] = wp::min(size[2], high);
            if (((unsigned)a >> 9) % 64 == 0) {  // anywhere in the slab
                there[0] = below((unsigned)(a >> 32), nx - size[0] + 1);
                there[1] = below((unsigned)b, nz - size[1] + 1);
            } else {
                const unsigned reach = (unsigned)b;
                there[0] = here[0] + (int)(reach % 9) + (int)((reach >> 8) % 9) - 8;
                there[1] = here[1] + (int)((reach >> 16) % 9) + (int)((reach >> 24) % 9) - 8;
            }
            there[2] = bottom + below((unsigned)a << 8, high - size[2] + 1);
            if (there[0] < 0 || there[1] < 0 || there[0] + size[0] > nx || there[1] + size[1] > nz) continue;
            float change;
            const float then = weigh(there, size, change);
            const float luck = (float)(mix(a ^ b) >> 40) * 5.9604645e-8f;  // from 0 to 1
            if (then > 0.0f || (then > -16.0f * heat && luck < wp::exp(then / heat))) {
                apply(there, size, change);
                ++applied;
            }
            const bool moves = now <= 0.0f ? then >= now : then >= now * (chance * 2.3283064e-10f);
            if (moves) {
                for (int i = 0; i < 3; ++i) here[i] = there[i];
                now = weigh(here, one, ignored);
            }
        }
        for (int i = 0; i < 3; ++i) kept[i] = here[i] - (i == 2 ? bottom : 0);
    }
    accepted.data[slab] = applied;
"""
).replace("SLAB_HEIGHTS", str(SLAB))


@wp.func_native(snippet=WALK)
def walk_slab(
    volume: wp.array3d[float],
    residual: wp.array3d[float],
    hull: wp.array3d[wp.uint8],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    corner: wp.vec2i,
    footprint: int,
    quantum: float,
    sad: float,
    heat: float,
    seed: int,
    sweep: int,
    chains_a_slab: int,
    first_chain: int,
    begin: int,
    slab: int,
    counts: wp.array[int],
    places: wp.array2d[int],
    accepted: wp.array[int],
):
    """Let all chains of a slab take their steps."""


@wp.kernel
def walk_kernel(
    first: int,
    colour: int,
    shift: int,
    volume: wp.array3d[float],
    residual: wp.array3d[float],
    hull: wp.array3d[wp.uint8],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    corner: wp.vec2i,
    footprint: int,
    quantum: float,
    sad: float,
    heat: float,
    seed: int,
    sweep: int,
    chains_a_slab: int,
    counts: wp.array[int],
    places: wp.array2d[int],
    accepted: wp.array[int],
):
    """Walk in every second slab."""
    slab = 2 * (first + wp.tid()) + colour
    walk_slab(
        volume,
        residual,
        hull,
        directions,
        weights,
        corner,
        footprint,
        quantum,
        sad,
        heat,
        seed,
        sweep,
        chains_a_slab,
        slab * chains_a_slab,
        slab * SLAB - shift,
        slab,
        counts,
        places,
        accepted,
    )


def walk(
    volume: wp.array3d[float],
    residual: wp.array3d[float],
    hull: wp.array3d[wp.uint8],
    directions: wp.array[wp.vec4],
    weights: wp.array[float],
    counts: wp.array[int],
    places: wp.array2d[int],
    accepted: wp.array[int],
    *,
    quantum: float,
    sad: float,
    seed: int,
    sweep: int,
    heat: float = 0.0,
    shift: int = 0,
    corner: tuple[int, int] = (0, 0),
    footprint: str = "box",
) -> None:
    """Let every chain take its steps, slab after slab, even ones first; volume and residual change in place.

    Args:
        volume: Density, zero outside the hull, shape (y, x, z).
        residual: Rendered minus wanted views, shape (y, view, u).
        hull: 1 where there may be light, shape (y, x, z).
        directions: cos t, sin t, m and 1 / m of every view's angle.
        weights: One factor a view.
        counts: Steps that each chain of a slab takes, shape (slab,).
        places: Where the chains are: x, z and height above the slab's bottom, shape (chain, 3); every slab has as many,
            one slab's after the other's.
        accepted: Applied quanta to write, shape (slab,).
        quantum: [grey level].
        sad: Weight of the sum of absolute differences [grey level].
        seed: Of the random numbers.
        sweep: Number of the sweep: another one makes other random numbers.
        heat: Temperature: a proposal that raises the energy by as much is applied with probability 1/e; 0 for never.
        shift: How far below the volume the first slab begins, less than ``SLAB``.
        corner: Where in the box the volume begins (x, z).
        footprint: ``box`` or ``joseph``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    arrays = {"volume": volume, "residual": residual, "hull": hull, "directions": directions, "weights": weights}
    device = checks.same_device(**arrays, counts=counts, places=places, accepted=accepted)
    checks.floats(3, volume=volume, residual=residual)
    checks.typed(wp.uint8, 3, hull=hull)
    checks.same_shape(volume=volume, hull=hull)
    checks.typed(wp.vec4, 1, directions=directions)
    checks.floats(1, weights=weights)
    checks.typed(wp.int32, 1, counts=counts, accepted=accepted)
    checks.typed(wp.int32, 2, places=places)
    views = directions.shape[0]
    checks.shape((volume.shape[0], views, residual.shape[2]), residual=residual)
    checks.shape((views,), weights=weights)
    slabs = len(range(-shift, volume.shape[0], SLAB))
    checks.shape((slabs,), counts=counts, accepted=accepted)
    if places.shape[0] % slabs or places.shape[1] != 3:
        found = tuple(places.shape)
        raise ValueError(f"places has shape {found}, expected (chains, 3), as many for each of {slabs} slabs")
    inputs = [volume, residual, hull, directions, weights, wp.vec2i(corner), FOOTPRINTS[footprint]]
    bits = int(np.uint32(seed).view(np.int32))
    inputs += [quantum, sad, heat, bits, sweep, places.shape[0] // slabs, counts, places, accepted]
    for colour in (0, 1):
        each(walk_kernel, (slabs - colour + 1) // 2, [colour, shift, *inputs], device)

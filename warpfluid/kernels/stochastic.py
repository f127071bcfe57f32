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
from warpfluid.kernels.projection import FOOTPRINTS

wp.set_module_options({"enable_backward": False})

SLAB = 4  # heights

# Defines `shade`: the bins that a rectangle of voxels covers in a view, and how much of it each takes.
SHADE = """
    enum { BINS = 10 };
    const int nx = volume.shape[1], nz = volume.shape[2], views = residual.shape[1], width = residual.shape[2];
    const double middle = 0.5 * (width - 1);
    const auto shade = [&](int a, int x, int z, int sx, int sz, float* share, int& first) {
        const double c = directions.data[a][0], s = directions.data[a][1], m = directions.data[a][2];
        const float per_m = directions.data[a][3];
        const double q = (x + corner[0] - middle) * c + (z + corner[1] - middle) * s + middle;
        const double start = footprint ? q : q - 0.5 * m + 0.5;
        first = (int)wp::floor(start + (sx - 1) * wp::min(c, 0.0) + (sz - 1) * wp::min(s, 0.0));
        int count = 0;
        for (int k = 0; k < BINS; ++k) share[k] = 0.0f;
        for (int i = 0; i < sx; ++i)
            for (int j = 0; j < sz; ++j) {
                const double low = start + i * c + j * s;
                const int bin = (int)wp::floor(low), k = wp::clamp(bin - first, 0, BINS - 2);
                const float past = (float)(low - bin);
                const float near = footprint ? (1.0f - past * per_m) * per_m : wp::min((1.0f - past) * per_m, 1.0f);
                const float far = footprint ? (1.0f - (1.0f - past) * per_m) * per_m : 1.0f - near;
                share[k] += wp::max(near, 0.0f);
                share[k + 1] += wp::max(far, 0.0f);
                count = wp::max(count, k + 2);
            }
        if (first < 0) {
            for (int k = 0; k < BINS; ++k) share[k] = k - first < BINS ? share[k - first] : 0.0f;
            count = wp::max(count + first, 0);
            first = 0;
        }
        return wp::min(count, width - first);
    };
"""

# Defines `weigh`: how much the energy falls by a quantum more or less in a box, whichever is better; `change` is it.
WEIGH = """
    const size_t level = (size_t)nx * nz, row = (size_t)views * width;
    const auto weigh = [&](const int* at, const int* size, float& change) {
        const int x = at[0], z = at[1], y = at[2], sx = size[0], sz = size[1], sy = size[2];
        change = 0.0f;
        float lowest = 1e30f, more = 0.0f, less = 0.0f;
        for (int k = y; k < y + sy; ++k)
            for (int i = x; i < x + sx; ++i)
                for (int j = z; j < z + sz; ++j) {
                    const size_t here = k * level + (size_t)i * nz + j;
                    if (!hull.data[here]) return -1e30f;
                    lowest = wp::min(lowest, volume.data[here]);
                }
        const float down = wp::min(quantum, lowest);
        const auto border = [&](size_t here, size_t there) {
            const float apart = volume.data[here] - volume.data[there], was = wp::abs(apart);
            more += wp::abs(apart + quantum) - was;
            less += wp::abs(apart - down) - was;
        };
        for (int k = y; k < y + sy; ++k) {
            for (int j = z; j < z + sz; ++j) {
                const size_t low = k * level + (size_t)x * nz + j, high = low + (size_t)(sx - 1) * nz;
                if (x > 0) border(low, low - nz);
                if (x + sx < nx) border(high, high + nz);
            }
            for (int i = x; i < x + sx; ++i) {
                const size_t low = k * level + (size_t)i * nz + z, high = low + sz - 1;
                if (z > 0) border(low, low - 1);
                if (z + sz < nz) border(high, high + 1);
            }
        }
        for (int i = x; i < x + sx; ++i)
            for (int j = z; j < z + sz; ++j) {
                const size_t low = y * level + (size_t)i * nz + j, high = low + (sy - 1) * level;
                if (y > 0) border(low, low - level);
                if (y + sy < heights) border(high, high + level);
            }
        float slope = 0.0f, curve = 0.0f, share[BINS];
        for (int a = 0; a < views; ++a) {
            int first;
            const int count = shade(a, x, z, sx, sz, share, first);
            const float* pixel = residual.data + y * row + (size_t)a * width + first;
            float sum = 0.0f, square = 0.0f;
            for (int b = 0; b < count; ++b) {
                for (int k = 0; k < sy; ++k) sum += share[b] * pixel[k * row + b];
                square += share[b] * share[b];
            }
            slope += weights.data[a] * sum;
            curve += weights.data[a] * square;
        }
        curve *= sy;
        const float gain_more = -(quantum * (quantum * curve + 2.0f * slope) + sad * more);
        const float gain_less = -(down * (down * curve - 2.0f * slope) + sad * less);
        const bool add = gain_more >= gain_less || down <= 0.0f;
        change = add ? quantum : -down;
        return add ? gain_more : gain_less;
    };
    const auto apply = [&](const int* at, const int* size, float change) {
        for (int k = at[2]; k < at[2] + size[2]; ++k)
            for (int i = at[0]; i < at[0] + size[0]; ++i)
                for (int j = at[1]; j < at[1] + size[1]; ++j)
                    volume.data[k * level + (size_t)i * nz + j] += change;
        float share[BINS];
        for (int a = 0; a < views; ++a) {
            int first;
            const int count = shade(a, at[0], at[1], size[0], size[1], share, first);
            float* pixel = residual.data + at[2] * row + (size_t)a * width + first;
            for (int k = 0; k < size[2]; ++k)
                for (int b = 0; b < count; ++b) pixel[k * row + b] += change * share[b];
        }
    };
"""

# Defines `draw`: 64 random bits of a chain's step (the finaliser of SplitMix64, Steele et al. 2014).
DRAW = """
    const auto mix = [](unsigned long long bits) {
        bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
        bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
        return bits ^ (bits >> 31);
    };
    const auto draw = [&](int chain, int step, int which) {
        const unsigned long long key = mix(((unsigned long long)(unsigned)seed << 32) ^ (unsigned)sweep);
        const unsigned long long counter = ((unsigned long long)(unsigned)chain << 32) | (unsigned)(2 * step + which);
        return mix(mix(key ^ counter) + 0x9e3779b97f4a7c15ULL);
    };
    const auto below = [](unsigned bits, int count) {  // a number from 0 to count - 1
        return (int)(((unsigned long long)bits * (unsigned)count) >> 32);
    };
"""

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

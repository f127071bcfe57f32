"""What a quantum of light does to the energy of a volume, in native code; ``stochastic`` lets chains walk by it.

Each text defines functions inside of a kernel that has the arrays and numbers of ``stochastic.walk`` at hand.
"""

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

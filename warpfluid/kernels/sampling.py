"""Reading a field between its places: linearly, or from a cubic B-spline."""

import functools
import math

import numpy as np
import warp as wp

SPLINE_POLE = math.sqrt(3.0) - 2.0
SPLINE_REACH = 12  # taps either side; the filter falls by 3.7 a tap

# Defines `linear` and `bounds` in the body of a native function. They read an array of `size` places an axis, which
# repeats after `period` places (0: it does not; positions beyond the first and last place are moved there).
LINEAR = """
    const auto between = [](float p, int size, int period, int& first, int& second) {
        const float turns = period > 0 ? p / (float)period : 0.0f;
        int whole = (int)turns;
        whole -= (float)whole > turns;
        p -= (float)period * (float)whole;
        p = p > 0.0f ? p : 0.0f;
        const float last = (float)(period > 0 ? period : size - 1);
        p = p < last ? p : (period > 0 ? 0.0f : last);
        first = (int)p;
        second = first + 1 < size ? first + 1 : (period > 0 ? 0 : first);
        return p - (float)first;
    };
    const auto mix = [](float a, float b, float share) { return a + share * (b - a); };
    const auto linear = [&](const float* data, const int* size, const int* period, float px, float pz, float py) {
        int x0, x1, z0, z1, y0, y1;
        const float a = between(px, size[0], period[0], x0, x1);
        const float b = between(pz, size[1], period[1], z0, z1);
        const float c = between(py, size[2], period[2], y0, y1);
        const auto column = [&](int x, int z) {
            const int start = (x * size[1] + z) * size[2];
            return mix(data[start + y0], data[start + y1], c);
        };
        return mix(mix(column(x0, z0), column(x0, z1), b), mix(column(x1, z0), column(x1, z1), b), a);
    };
    const auto bounds = [&](const float* data, const int* size, const int* period, float px, float pz, float py,
                            float& low, float& high) {
        int x[2], z[2], y[2];
        between(px, size[0], period[0], x[0], x[1]);
        between(pz, size[1], period[1], z[0], z[1]);
        between(py, size[2], period[2], y[0], y[1]);
        low = high = data[(x[0] * size[1] + z[0]) * size[2] + y[0]];
        for (int corner = 1; corner < 8; ++corner) {
            const float value = data[(x[corner & 1] * size[1] + z[corner >> 1 & 1]) * size[2] + y[corner >> 2]];
            low = value < low ? value : low;
            high = value > high ? value : high;
        }
    };
"""


@wp.func
def trilinear(field: wp.array3d[float], at: wp.vec3) -> float:
    """Interpolate linearly, the nearest voxel's value beyond the border."""
    i = wp.clamp(at[0], 0.0, float(field.shape[0] - 1))
    j = wp.clamp(at[1], 0.0, float(field.shape[1] - 1))
    k = wp.clamp(at[2], 0.0, float(field.shape[2] - 1))
    i0 = wp.min(int(i), wp.max(field.shape[0] - 2, 0))
    j0 = wp.min(int(j), wp.max(field.shape[1] - 2, 0))
    k0 = wp.min(int(k), wp.max(field.shape[2] - 2, 0))
    i1 = wp.min(i0 + 1, field.shape[0] - 1)
    j1 = wp.min(j0 + 1, field.shape[1] - 1)
    k1 = wp.min(k0 + 1, field.shape[2] - 1)
    a = i - float(i0)
    b = j - float(j0)
    c = k - float(k0)
    near = wp.lerp(
        wp.lerp(field[i0, j0, k0], field[i0, j0, k1], c), wp.lerp(field[i0, j1, k0], field[i0, j1, k1], c), b
    )
    far = wp.lerp(wp.lerp(field[i1, j0, k0], field[i1, j0, k1], c), wp.lerp(field[i1, j1, k0], field[i1, j1, k1], c), b)
    return wp.lerp(near, far, a)


@wp.func
def fetch(field: wp.array3d[float], i: int, j: int, k: int) -> float:
    """Return a voxel, 0 beyond the border."""
    if i < 0 or j < 0 or k < 0 or i >= field.shape[0] or j >= field.shape[1] or k >= field.shape[2]:
        return float(0.0)
    return field[i, j, k]


@wp.func
def spline_weights(t: float) -> wp.vec4:
    """Weights of the cubic B-spline at a fraction of a voxel."""
    r = 1.0 - t
    return wp.vec4(
        r * r * r / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0,
        t * t * t / 6.0,
    )


@functools.cache
def spline_taps(device: str) -> wp.array:
    """Return the filter that turns values into coefficients of the cubic B-spline through them."""
    taps = SPLINE_POLE ** np.abs(np.arange(-SPLINE_REACH, SPLINE_REACH + 1))
    return wp.array(taps / taps.sum(), dtype=float, device=device)


@wp.func
def coarse_place(x: int, z: int, y: int, factor: int) -> wp.vec3:
    """Return where the centre of a fine voxel lies on the coarse lattice."""
    fine = wp.vec3(float(x) + 0.5, float(z) + 0.5, float(y) + 0.5)
    return fine / float(factor) - wp.vec3(0.5, 0.5, 0.5)


def coarse_shape(shape: tuple[int, ...], factor: int) -> tuple[int, ...]:
    """Return the shape of a lattice of cubes of voxels."""
    return tuple(-(-n // factor) for n in shape)

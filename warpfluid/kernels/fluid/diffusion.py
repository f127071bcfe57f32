"""Let a field spread by diffusion, exactly: a separable convolution with the heat kernel of the grid.

The heat equation with the Laplacian of neighbouring differences is solved by weights of variance 2 D t, however small
or large (Lindeberg 1990); samples of a Gaussian far narrower than a voxel would spread nothing. Walls are mirrors.
"""

import functools

import numpy as np
import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, launch
from warpfluid.kernels.sides import SIX

wp.set_module_options({"enable_backward": False})

NEGLIGIBLE = 1.0e-8  # share of a value that a tap may leave out; float32 does not resolve it

# Defines `inside` in the body of a native function: the place whose value stands at a place beyond the border, with its
# sign in `sign`. Walls mirror scalars and what flows along them; what flows through them changes sign. Beyond open
# sides scalars are 0 and velocities mirrored. Faces lie on the border along their own axis, others half a voxel within.
MIRRORS = """
    const int n = size[axis], on_border = axis == place, low = sides[2 * axis], high = sides[2 * axis + 1];
    const int period = n - on_border;
    const auto inside = [&](int there, float& sign) {
        sign = 1.0f;
        if (period == 0) return 0;
        if (low == 2) return (there % period + period) % period;
        while (there < 0 || there >= n) {
            const int side = there < 0 ? low : high;
            if (side == 1 && on_border) sign = -sign;
            if (side == 0 && place == 3) sign = 0.0f;
            there = there < 0 ? -there - !on_border : 2 * n - 1 - there - on_border;
        }
        return there;
    };
    const int radius = taps.shape[0] / 2;
    float sum[RUN] = {};
"""

SPREAD = (
    """
    const int size[3] = {field.shape[0], field.shape[1], field.shape[2]}, heights = size[2];"""
    + RUN_OF_HEIGHTS
    + MIRRORS
    + """
    const float* column = field.data + ((size_t)x * size[1] + z) * heights;
    for (int tap = -radius; tap <= radius; ++tap) {
        const float weight = taps.data[tap + radius];
        if (axis == 2 && (y + tap < 0 || y + tap + count > heights)) {
            for (int l = 0; l < count; ++l) {
                float sign;
                const int there = inside(y + tap + l, sign);
                sum[l] += sign * weight * column[there];
            }
            continue;
        }
        float sign = 1.0f;
        const float* from = column + y + tap;
        if (axis < 2) {
            const int there = inside((axis == 0 ? x : z) + tap, sign);
            from = field.data + (axis == 0 ? (size_t)there * size[1] + z : (size_t)x * size[1] + there) * heights + y;
        }
        const float signed_weight = sign * weight;
        if (count < RUN)
            for (int l = 0; l < count; ++l) sum[l] += signed_weight * from[l];
        else
            for (int l = 0; l < RUN; ++l) sum[l] += signed_weight * from[l];
    }
    float* to = out.data + ((size_t)x * size[1] + z) * heights + y;
    for (int l = 0; l < count; ++l) to[l] = sum[l];
"""
)


@wp.func_native(snippet=SPREAD)
def spread_run(
    field: wp.array3d[float],
    taps: wp.array[float],
    axis: int,
    sides: SIX,
    place: int,
    x: int,
    z: int,
    block: int,
    out: wp.array3d[float],
):
    """Weigh the neighbours of a run of heights along an axis."""


@wp.kernel
def spread_kernel(
    first_row: int,
    first_block: int,
    field: wp.array3d[float],
    taps: wp.array[float],
    axis: int,
    sides: SIX,
    place: int,
    out: wp.array3d[float],
):
    """Let a field spread along one axis: 0 is x, 1 is z, 2 is y."""
    i, z, j = wp.tid()
    spread_run(field, taps, axis, sides, place, first_row + i, z, first_block + j, out)


@functools.lru_cache(maxsize=32)
def heat_taps(variance: float, device: str) -> wp.array[float]:
    """Return what one voxel becomes after diffusion, exp(-v) I_n(v), as an array of odd length, total 1."""
    count = 64 + 2 * int(8.0 * variance**0.5)
    frequencies = 2.0 * np.pi * np.fft.rfftfreq(count)
    weights = np.fft.irfft(np.exp(variance * (np.cos(frequencies) - 1.0)), count)
    radius = int(np.argmax(np.append(weights[1 : count // 2], 0.0) < NEGLIGIBLE))
    half = weights[: radius + 1]
    taps = np.concatenate([half[:0:-1], half])
    return wp.array(taps / taps.sum(), dtype=float, device=device)


def spread(
    field: wp.array3d[float],
    variance: float,
    sides: SIX,
    *,
    place: int,
    scratch: wp.array3d[float] | None = None,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Let a field spread by diffusion; stable for any variance.

    Args:
        field: Shape (x, z, y) of the places.
        variance: Twice the coefficient of diffusion times the duration [voxel^2]; 0 leaves the bits equal.
        sides: What the six sides are. Closed ones let nothing through. Beyond open ones scalars are 0, and components
            of a velocity mirrored.
        place: 0, 1 or 2 for a field on the faces along x, z or y; 3 for one in the voxels' centres.
        scratch: Memory of the field's shape to work in, neither ``field`` nor ``out``.
        out: Array to write; it may be ``field``.

    Returns:
        The spread field, shape of ``field``.

    Raises:
        ValueError: If shapes, types or devices do not fit, or the variance is below 0 or not finite.
    """
    checks.same_device(field=field)
    out = wp.empty_like(field) if out is None else out
    scratch = wp.empty_like(field) if scratch is None else scratch
    device = checks.same_device(field=field, scratch=scratch, out=out)
    checks.floats(3, field=field, scratch=scratch, out=out)
    checks.same_shape(field=field, scratch=scratch, out=out)
    if not 0.0 <= variance < np.inf:
        raise ValueError(f"variance is {variance}, expected a number >= 0, in square voxels")
    if place not in (0, 1, 2, 3):
        raise ValueError(f"place is {place}, expected the axis of the faces, 0, 1 or 2, or 3 for the centres")
    if variance == 0.0:
        return _copied(field, out)
    taps = heat_taps(float(variance), str(device))
    source = field
    for axis in range(3):
        target = scratch if source is out else out
        launch(spread_kernel, field.shape, [source, taps, axis, sides, place], [target], device)
        source = target
    return _copied(source, out)


def _copied(source: wp.array, out: wp.array) -> wp.array:
    if source is not out:
        wp.copy(out, source)
    return out

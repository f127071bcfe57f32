"""How well two pictures agree near a flow: truncated normalised cross-correlation, expanded to second order.

The data term of Werlberger, Pock and Bischof (2010) is 1 - NCC over a small window, at most 1: fire changes its
brightness from frame to frame, and NCC sees neither gain nor offset. They take its derivatives by finite differences.
Here they are closed: for windows a, b of unit length the term is |a - b|^2 / 2, whose gradient is exactly 0 where the
pictures agree, and whose Gauss-Newton matrix is never negative. A window with no structure above the noise has no say.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.launch import RUN_OF_HEIGHTS, run_count

wp.set_module_options({"enable_backward": False})

RADIUS = 3  # of the window [pixel]
SIGMA = 1.6  # of its Gaussian weights [pixel]
NOISE = wp.constant(1.0e-4)  # variance of noise: that of 2.5 grey levels
ROUNDING = wp.constant(1.0e-6)  # of a variance, more than float32 makes
MEANS = 14  # of a, b, bu, bv, aa, bb, ab, abu, abv, bbu, bbv, bubu, bubv, bvbv; u and v mark slopes

WINDOW_MEANS = (
    """
    const int width = picture.shape[0], heights = picture.shape[1];
    const size_t plane = (size_t)width * heights;"""
    + RUN_OF_HEIGHTS
    + f"""
    float sum[{MEANS}][RUN] = {{}}, weight[RUN] = {{}};
    for (int du = -{RADIUS}; du <= {RADIUS}; ++du) {{
        if (u + du < 0 || u + du >= width) continue;
        for (int dv = -{RADIUS}; dv <= {RADIUS}; ++dv) {{
            const float w = expf(-0.5f * (du * du + dv * dv) / ({SIGMA}f * {SIGMA}f));
            const size_t there = (size_t)(u + du) * heights + y + dv;
            const int low = y + dv < 0 ? -(y + dv) : 0;
            const int high = y + dv + count > heights ? heights - y - dv : count;
            const float *pa = picture.data + there, *pb = fetched.data + there;
            const float *pu = pb + plane, *pv = pu + plane;
            for (int l = low; l < high; ++l) {{
                const float wa = w * pa[l], wb = w * pb[l], wu = w * pu[l], wv = w * pv[l];
                weight[l] += w;
                sum[0][l] += wa;
                sum[1][l] += wb;
                sum[2][l] += wu;
                sum[3][l] += wv;
                sum[4][l] += wa * pa[l];
                sum[5][l] += wb * pb[l];
                sum[6][l] += wa * pb[l];
                sum[7][l] += wa * pu[l];
                sum[8][l] += wa * pv[l];
                sum[9][l] += wb * pu[l];
                sum[10][l] += wb * pv[l];
                sum[11][l] += wu * pu[l];
                sum[12][l] += wu * pv[l];
                sum[13][l] += wv * pv[l];
            }}
        }}
    }}
    float* to = out.data + (size_t)u * heights + y;
    for (int m = 0; m < {MEANS}; ++m)
        for (int l = 0; l < count; ++l) to[m * plane + l] = sum[m][l] / weight[l];
"""
)


@wp.func_native(snippet=WINDOW_MEANS)
def window_means(picture: wp.array2d[float], fetched: wp.array3d[float], u: int, block: int, out: wp.array3d[float]):
    """Average products of two pictures and the slopes of one over the window, for a run of heights."""


@wp.kernel
def window_kernel(picture: wp.array2d[float], fetched: wp.array3d[float], out: wp.array3d[float]):
    """Average over the windows of one run of heights."""
    u, block = wp.tid()
    window_means(picture, fetched, u, block, out)


@wp.func
def cubic_weights(t: float) -> wp.vec4:
    """Weights of the four pixels about a fraction of one: the cubic through them of Catmull and Rom."""
    return wp.vec4(
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    )


@wp.func
def cubic_slopes(t: float) -> wp.vec4:
    """Derivatives of these weights."""
    return wp.vec4((-1.5 * t + 2.0) * t - 0.5, (4.5 * t - 5.0) * t, (-4.5 * t + 4.0) * t + 0.5, (1.5 * t - 1.0) * t)


@wp.kernel
def fetch_kernel(picture: wp.array2d[float], flow: wp.array3d[float], out: wp.array3d[float]):
    """Read a picture and its slopes where the flow leads, the nearest pixel beyond the border."""
    u, v = wp.tid()
    right = picture.shape[0] - 1
    top = picture.shape[1] - 1
    at_u = wp.clamp(float(u) + flow[0, u, v], 0.0, float(right))
    at_v = wp.clamp(float(v) + flow[1, u, v], 0.0, float(top))
    i = int(at_u)
    j = int(at_v)
    across = cubic_weights(at_u - float(i))
    along = cubic_weights(at_v - float(j))
    steep_across = cubic_slopes(at_u - float(i))
    steep_along = cubic_slopes(at_v - float(j))
    found = wp.vec3(0.0, 0.0, 0.0)
    for p in range(4):
        column = float(0.0)
        slope = float(0.0)
        for q in range(4):
            pixel = picture[wp.clamp(i + p - 1, 0, right), wp.clamp(j + q - 1, 0, top)]
            column += along[q] * pixel
            slope += steep_along[q] * pixel
        found += wp.vec3(across[p] * column, steep_across[p] * column, across[p] * slope)
    for c in range(3):
        out[c, u, v] = found[c]


@wp.kernel
def expand_kernel(means: wp.array3d[float], flow: wp.array3d[float], weight: float, out: wp.array3d[float]):
    """Turn the means of a window into the pull and the stiffness of the data term."""
    u, v = wp.tid()
    a = means[0, u, v]
    b = means[1, u, v]
    slope = wp.vec2(means[2, u, v], means[3, u, v])
    aa = means[4, u, v] - a * a + ROUNDING
    bb = means[5, u, v] - b * b + ROUNDING
    ab = means[6, u, v] - a * b + ROUNDING
    a_slope = wp.vec2(means[7, u, v], means[8, u, v]) - a * slope
    b_slope = wp.vec2(means[9, u, v], means[10, u, v]) - b * slope
    at_u = float(u) + flow[0, u, v]
    at_v = float(v) + flow[1, u, v]
    say = float(0.0)
    if at_u >= 0.0 and at_v >= 0.0 and at_u <= float(means.shape[1] - 1) and at_v <= float(means.shape[2] - 1):
        say = weight * wp.max(ab / wp.sqrt(aa * bb), 0.0)  # pictures that contradict each other show no motion
        say *= aa / (aa + NOISE) * bb / (bb + NOISE)
    pull = say / wp.sqrt(aa * bb) * (a_slope - ab / bb * b_slope)
    out[0, u, v] = pull[0]
    out[1, u, v] = pull[1]
    out[2, u, v] = say / bb * (means[11, u, v] - slope[0] * slope[0] - b_slope[0] * b_slope[0] / bb)
    out[3, u, v] = say / bb * (means[12, u, v] - slope[0] * slope[1] - b_slope[0] * b_slope[1] / bb)
    out[4, u, v] = say / bb * (means[13, u, v] - slope[1] * slope[1] - b_slope[1] * b_slope[1] / bb)


def expand(
    now: wp.array2d[float],
    later: wp.array2d[float],
    flow: wp.array3d[float],
    *,
    weight: float,
    out: wp.array3d[float] | None = None,
) -> wp.array3d[float]:
    """Expand weight (1 - NCC) about a flow, for every window of a picture.

    Args:
        now: The picture whose motion is sought, light of white 1, shape (u, v).
        later: The picture to find it in, the same shape.
        flow: Displacement along u and v so far [pixel], shape (2, u, v).
        weight: Of this term against the smoothness of the flow.
        out: Array to write, shape (5, u, v); a new one when omitted.

    Returns:
        Pull along u and v, the negative gradient, then the stiffness: its uu, uv and vv; shape (5, u, v).

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(now=now)
    size = tuple(now.shape)
    out = wp.empty((5, *size), dtype=float, device=now.device) if out is None else out
    device = checks.same_device(now=now, later=later, flow=flow, out=out)
    checks.floats(2, now=now, later=later)
    checks.floats(3, flow=flow, out=out)
    checks.same_shape(now=now, later=later)
    checks.shape((2, *size), flow=flow)
    checks.shape((5, *size), out=out)
    fetched, means = (wp.empty((count, *size), dtype=float, device=device) for count in (3, MEANS))
    wp.launch(fetch_kernel, dim=size, inputs=[later, flow], outputs=[fetched], device=device)
    runs = (size[0], run_count(size[1], device))
    wp.launch(window_kernel, dim=runs, inputs=[now, fetched], outputs=[means], device=device)
    wp.launch(expand_kernel, dim=size, inputs=[means, flow, weight], outputs=[out], device=device)
    return out

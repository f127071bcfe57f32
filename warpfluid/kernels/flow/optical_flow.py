"""Make a flow smooth where a picture is one thing: non-local total variation, by a primal-dual method.

Werlberger, Pock and Bischof (2010): neighbours up to two pixels apart may differ at a price, less so the nearer they
are and the more alike they look. The price is quadratic for small differences (Huber), as eddies turn smoothly. The
saddle point is found after Chambolle and Pock (2011) with the step lengths of Pock and Chambolle (2011). A picture is
small, and its fields stay in the cache: one thread a launch is quicker than sharing it out.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.flow.pair_prices import PAIRS
from warpfluid.kernels.launch import CPU_RUN, CUDA_RUN, RUN_OF_HEIGHTS, run_count

wp.set_module_options({"enable_backward": False})

HUBER = 0.5  # difference of displacements up to which the price is quadratic [pixel]
REACH = wp.constant(1.0)  # farthest from where the pictures were compared [pixel]

PAIR = "const int du = pair < 2 ? 0 : 1 + (pair - 2) / 5, dv = pair < 2 ? pair + 1 : (pair - 2) % 5 - 2;"

RAISE_DUAL = (
    """
    const int width = ahead.shape[1], heights = ahead.shape[2];"""
    + RUN_OF_HEIGHTS
    + f"""
    const size_t plane = (size_t)width * heights, start = (size_t)u * heights + y;
    for (int pair = 0; pair < {PAIRS}; ++pair) {{
        {PAIR}
        if (u + du >= width) continue;
        const int low = y + dv < 0 ? -(y + dv) : 0;
        const int high = y + dv + count > heights ? heights - y - dv : count;
        const float* price = prices.data + pair * plane + start;
        for (int c = 0; c < 2; ++c) {{
            const float* here = ahead.data + c * plane + start;
            const float* there = here + du * heights + dv;
            float* p = dual.data + (2 * pair + c) * plane + start;
            for (int l = low; l < high; ++l) {{
                const float raised = (p[l] + 0.5f * price[l] * (there[l] - here[l])) / (1.0f + 0.5f * {HUBER}f);
                const float capped = raised > price[l] ? price[l] : raised;
                p[l] = capped < -price[l] ? -price[l] : capped;
            }}
        }}
    }}
"""
)

GATHER_PULL = (
    """
    const int width = dual.shape[1], heights = dual.shape[2];"""
    + RUN_OF_HEIGHTS
    + f"""
    const size_t plane = (size_t)width * heights, start = (size_t)u * heights + y;
    for (int c = 0; c < 2; ++c) {{
        float pull[RUN] = {{}};
        for (int pair = 0; pair < {PAIRS}; ++pair) {{
            {PAIR}
            const int low = y - dv < 0 ? dv - y : 0;
            const int high = y - dv + count > heights ? heights - y + dv : count;
            const float* owned = dual.data + (2 * pair + c) * plane + start;
            const float* others = owned - du * heights - dv;
            for (int l = 0; l < count; ++l) pull[l] += owned[l];
            if (u >= du)
                for (int l = low; l < high; ++l) pull[l] -= others[l];
        }}
        for (int l = 0; l < count; ++l) out.data[c * plane + start + l] = pull[l];
    }}
"""
)


@wp.func_native(snippet=RAISE_DUAL)
def raise_dual(ahead: wp.array3d[float], prices: wp.array3d[float], u: int, block: int, dual: wp.array3d[float]):
    """Let differences of a run of heights pull harder, each at most with its price."""


@wp.func_native(snippet=GATHER_PULL)
def gather_pull(dual: wp.array3d[float], u: int, block: int, out: wp.array3d[float]):
    """Add up what the pairs of a run of heights pull."""


@wp.kernel
def dual_kernel(ahead: wp.array3d[float], prices: wp.array3d[float], dual: wp.array3d[float]):
    """Raise the dual variables of one run of heights."""
    u, block = wp.tid()
    raise_dual(ahead, prices, u, block, dual)


@wp.kernel
def primal_kernel(
    dual: wp.array3d[float],
    expansion: wp.array3d[float],
    centre: wp.array3d[float],
    steps: wp.array2d[float],
    run: int,
    pull: wp.array3d[float],
    flow: wp.array3d[float],
    ahead: wp.array3d[float],
):
    """Follow the pull of the pairs, and of the pictures implicitly; look as far ahead once more."""
    u, block = wp.tid()
    gather_pull(dual, u, block, pull)
    for v in range(block * run, wp.min((block + 1) * run, flow.shape[2])):
        step = steps[u, v]
        before = wp.vec2(flow[0, u, v], flow[1, u, v])
        middle = wp.vec2(centre[0, u, v], centre[1, u, v])
        drawn = wp.vec2(pull[0, u, v] + expansion[0, u, v], pull[1, u, v] + expansion[1, u, v])
        goal = before + step * drawn - middle
        uu = 1.0 + step * expansion[2, u, v]
        uv = step * expansion[3, u, v]
        vv = 1.0 + step * expansion[4, u, v]
        part = 1.0 / (uu * vv - uv * uv)
        after_u = middle[0] + wp.clamp(part * (vv * goal[0] - uv * goal[1]), -REACH, REACH)
        after_v = middle[1] + wp.clamp(part * (uu * goal[1] - uv * goal[0]), -REACH, REACH)
        flow[0, u, v] = after_u
        flow[1, u, v] = after_v
        ahead[0, u, v] = 2.0 * after_u - before[0]
        ahead[1, u, v] = 2.0 * after_v - before[1]


def regularize(
    flow: wp.array3d[float],
    expansion: wp.array3d[float],
    prices: wp.array3d[float],
    steps: wp.array2d[float],
    dual: wp.array3d[float],
    *,
    iterations: int,
) -> wp.array3d[float]:
    """Weigh what the pictures say about a flow against its smoothness, in place.

    Args:
        flow: Displacement along u and v [pixel], shape (2, u, v), at which the pictures were compared.
        expansion: What they say, of ``correlation.expand``, shape (5, u, v).
        prices: Of ``price_pairs``, shape (12, u, v).
        steps: Of ``price_pairs``, shape (u, v).
        dual: State of the method, 0 at first, shape (24, u, v); it is kept from call to call.
        iterations: Primal-dual iterations.

    Returns:
        ``flow``, at most a pixel from where it was along u and v.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    device = checks.same_device(flow=flow, expansion=expansion, prices=prices, steps=steps, dual=dual)
    size = tuple(flow.shape[1:])
    checks.floats(3, flow=flow, expansion=expansion, prices=prices, dual=dual)
    checks.floats(2, steps=steps)
    for name, array, count in (("flow", flow, 2), ("expansion", expansion, 5), ("prices", prices, PAIRS)):
        checks.shape((count, *size), **{name: array})
    checks.shape((2 * PAIRS, *size), dual=dual)
    checks.shape(size, steps=steps)
    centre, ahead, pull = wp.clone(flow), wp.clone(flow), wp.empty_like(flow)
    runs = (size[0], run_count(size[1], device))
    inputs = [dual, expansion, centre, steps, CUDA_RUN if device.is_cuda else CPU_RUN]
    for _ in range(iterations):
        wp.launch(dual_kernel, dim=runs, inputs=[ahead, prices], outputs=[dual], device=device)
        wp.launch(primal_kernel, dim=runs, inputs=inputs, outputs=[pull, flow, ahead], device=device)
    return flow

"""What it costs that neighbouring pixels move apart: less the farther they are and the less alike they look.

The support weights of Werlberger, Pock and Bischof (2010). Every pixel owns the 12 of its 24 pairs that lie ahead:
those with the pixels (0, 1), (0, 2), and (1 or 2, -2 to 2) from it along u and v.
"""

import warp as wp

from warpfluid.kernels import checks

wp.set_module_options({"enable_backward": False})

PAIRS = wp.constant(12)
DISTANCE = wp.constant(2.0)  # at which the price has fallen to 1 / e [pixel]
CONTRAST = wp.constant(0.3)  # the same for the difference in light, white being 1


@wp.func
def pair_offset(pair: int) -> wp.vec2i:
    """Return how far ahead the other pixel of a pair lies."""
    if pair < 2:
        return wp.vec2i(0, pair + 1)
    return wp.vec2i(1 + (pair - 2) / 5, (pair - 2) % 5 - 2)


@wp.kernel
def price_kernel(picture: wp.array2d[float], prices: wp.array3d[float]):
    """Say what a difference between the pixels of a pair costs, 0 beyond the border."""
    pair, u, v = wp.tid()
    offset = pair_offset(pair)
    i = u + offset[0]
    j = v + offset[1]
    price = float(0.0)
    if i < picture.shape[0] and j >= 0 and j < picture.shape[1]:
        far = wp.sqrt(float(offset[0] * offset[0] + offset[1] * offset[1])) / DISTANCE
        price = wp.exp(-far - wp.abs(picture[u, v] - picture[i, j]) / CONTRAST)
    prices[pair, u, v] = price


@wp.kernel
def step_kernel(prices: wp.array3d[float], steps: wp.array2d[float]):
    """Find a pixel's step: the inverse of what its pairs can pull."""
    u, v = wp.tid()
    total = float(0.0)
    for pair in range(PAIRS):
        offset = pair_offset(pair)
        i = u - offset[0]
        j = v - offset[1]
        total += prices[pair, u, v]
        if i >= 0 and j >= 0 and j < steps.shape[1]:
            total += prices[pair, i, j]
    steps[u, v] = 1.0 / wp.max(total, 1.0e-6)


def price_pairs(picture: wp.array2d[float]) -> tuple[wp.array3d[float], wp.array2d[float]]:
    """Weigh pairs of neighbours by distance and likeness.

    Args:
        picture: Light of white 1, shape (u, v).

    Returns:
        Price of a difference, shape (12, u, v), one a pair ahead; and the length of a pixel's step, shape (u, v).

    Raises:
        ValueError: If the picture is no 2-D float array.
    """
    device = checks.same_device(picture=picture)
    checks.floats(2, picture=picture)
    prices = wp.empty((PAIRS, *picture.shape), dtype=float, device=device)
    steps = wp.empty_like(picture)
    wp.launch(price_kernel, dim=prices.shape, inputs=[picture], outputs=[prices], device=device)
    wp.launch(step_kernel, dim=steps.shape, inputs=[prices], outputs=[steps], device=device)
    return prices, steps

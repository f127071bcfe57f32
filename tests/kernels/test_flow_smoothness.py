"""The smoothness of the optical flow: prices, and the minimum that the iterations find."""

import itertools

import numpy as np
import pytest
import warp as wp
from scipy import ndimage, optimize

from warpfluid.kernels.flow import optical_flow, pair_prices, pictures

SIZE = (7, 52)  # more heights than a run
AHEAD = [(0, 1), (0, 2), *itertools.product((1, 2), range(-2, 3))]


def on(device, array):
    """Copy to a device."""
    return wp.array(np.ascontiguousarray(array), dtype=float, device=device)


def regularized(flow, expansion, picture, iterations, device, dual=None):
    """Return the flow after some iterations."""
    prices, steps = pair_prices.price_pairs(on(device, picture))
    dual = wp.zeros((24, *picture.shape), dtype=float, device=device) if dual is None else dual
    arrays = (on(device, flow), on(device, expansion), prices, steps, dual)
    return optical_flow.regularize(*arrays, iterations=iterations).numpy()


def definition(picture):
    """Prices and steps by the formula, pixel by pixel."""
    width, height = picture.shape
    prices, total = np.zeros((12, width, height)), np.zeros((width, height))
    for pair, (du, dv) in enumerate(AHEAD):
        for u, v in np.ndindex(width, height):
            if u + du < width and 0 <= v + dv < height:
                unlike = abs(picture[u, v] - picture[u + du, v + dv]) / 0.3
                prices[pair, u, v] = np.exp(-np.hypot(du, dv) / 2 - unlike)
                total[u, v] += prices[pair, u, v]
                total[u + du, v + dv] += prices[pair, u, v]
    return prices, 1 / total


def test_prices(device):
    """Against the definition."""
    picture = np.random.default_rng(0).random(SIZE).astype(np.float32)
    for found, expected in zip(pair_prices.price_pairs(on(device, picture)), definition(picture), strict=True):
        np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5)


def energy(flow, expansion, prices):
    """What the flow costs, Huber prices of all pairs and the expansion about 0; and the slope of that."""
    pull, (uu, uv, vv) = expansion[:2], expansion[2:]
    x, y = flow = flow.reshape(2, *SIZE)
    bent = np.stack([uu * x + uv * y, uv * x + vv * y])
    total, slope = (flow * (0.5 * bent - pull)).sum(), bent - pull
    for pair, (du, dv) in enumerate(AHEAD):
        low, high = max(0, -dv), SIZE[1] - max(0, dv)
        here = np.s_[:, : SIZE[0] - du, low:high]
        there = np.s_[:, du:, low + dv : high + dv]
        price, apart = prices[pair][here[1:]], flow[there] - flow[here]
        capped = np.clip(apart / optical_flow.HUBER, -1, 1)
        total += (price * capped * (apart - 0.5 * optical_flow.HUBER * capped)).sum()
        slope[there] += price * capped
        slope[here] -= price * capped
    return total, slope.ravel()


def test_finds_the_minimum(device):
    """SciPy finds the same, from nothing."""
    rng = np.random.default_rng(1)
    picture = ndimage.gaussian_filter(rng.random(SIZE), 1)
    slopes = rng.standard_normal((2, *SIZE))
    stiffness = np.stack([slopes[0] ** 2, slopes[0] * slopes[1], slopes[1] ** 2])
    expansion = np.concatenate([0.5 * rng.standard_normal((2, *SIZE)) * np.abs(slopes), stiffness])
    found = regularized(np.zeros((2, *SIZE)), expansion, picture, 1000, device)
    assert np.abs(found).max() < 0.99  # else it would be held where it is, and the energy below another one
    prices, _ = definition(picture)
    start = np.zeros(found.size)
    least = optimize.minimize(energy, start, (expansion, prices), "L-BFGS-B", jac=True, options={"maxiter": 2000})
    assert least.fun < energy(start, expansion, prices)[0] - 5
    assert energy(found.astype(float), expansion, prices)[0] == pytest.approx(least.fun, rel=1e-4)
    np.testing.assert_allclose(found.ravel(), least.x, atol=5e-3)


def test_nothing_to_say_leaves_uniform_motion(device):
    """Without pull, what is smooth stays as it is, bit for bit."""
    flow = np.broadcast_to(np.reshape([1.5, -0.25], (2, 1, 1)), (2, *SIZE))
    picture = np.random.default_rng(2).random(SIZE)
    np.testing.assert_array_equal(regularized(flow, np.zeros((5, *SIZE)), picture, 20, device), flow)


def test_goes_no_farther_than_a_pixel(device):
    """Beyond it the expansion means nothing."""
    expansion = np.zeros((5, *SIZE))
    expansion[0], expansion[1] = 1e4, -1e4
    found = regularized(np.full((2, *SIZE), 3.0), expansion, np.zeros(SIZE), 5, device)
    np.testing.assert_allclose(found[0], 4.0)
    np.testing.assert_allclose(found[1], 2.0)


def test_median(device):
    """Against SciPy."""
    flow = np.random.default_rng(3).standard_normal((2, *SIZE)).astype(np.float32)
    expected = ndimage.median_filter(flow, (1, 3, 3), mode="nearest")
    np.testing.assert_array_equal(pictures.median(on(device, flow)).numpy(), expected)


@pytest.mark.parametrize("size", [(7, 52), (14, 26), (3, 5), (1, 1)])
def test_resize(device, size):
    """A slope keeps its steepness between the centres of the border pixels; the own size changes nothing."""
    u, v = np.indices(SIZE)
    field = np.stack([u, v, 2 * u - v]).astype(np.float32)
    i, j = (np.clip((np.arange(n) + 0.5) * old / n - 0.5, 0, old - 1) for n, old in zip(size, SIZE, strict=True))
    expected = np.stack(np.broadcast_arrays(i[:, None], j[None], 2 * i[:, None] - j[None]))
    np.testing.assert_allclose(pictures.resize(on(device, field), size).numpy(), expected, atol=1e-4)

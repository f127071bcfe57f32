"""The data term of the optical flow: derivatives against differences of what they are derived from."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.flow import correlation

SIZE = (21, 60)  # more heights than a run
NEAR = slice(5, -5)  # far enough from the border that windows and cubics are whole


def waves(shift=(0.0, 0.0)):
    """A picture that can be had anywhere."""
    u, v = np.indices(SIZE) + np.reshape(shift, (2, 1, 1))
    return (0.5 + 0.2 * np.sin(0.5 * u + 0.3 * v) + 0.15 * np.cos(0.35 * u - 0.45 * v)).astype(np.float32)


def expand(now, later, flow, device):
    """Expand for arrays of NumPy."""
    arrays = (wp.array(np.ascontiguousarray(array), dtype=float, device=device) for array in (now, later, flow))
    return correlation.expand(*arrays, weight=1.0).numpy()


def uniform(u, v):
    """The same displacement everywhere."""
    return np.broadcast_to(np.reshape([u, v], (2, 1, 1)), (2, *SIZE)).astype(np.float32)


def likeness(now, later):
    """NCC of every whole window, and the weight that a window has."""
    r = correlation.RADIUS
    taps = np.exp(-0.5 * (np.arange(-r, r + 1) / correlation.SIGMA) ** 2)
    weights = np.outer(taps, taps) / taps.sum() ** 2
    a, b = (np.lib.stride_tricks.sliding_window_view(x.astype(float), (2 * r + 1,) * 2) for x in (now, later))

    def mean(x):
        return (weights * x).sum((-2, -1))

    aa, bb, ab = (mean(x * y) - mean(x) * mean(y) for x, y in ((a, a), (b, b), (a, b)))
    noise = 1e-4
    out = np.zeros((2, *SIZE))
    out[:, r:-r, r:-r] = ab / np.sqrt(aa * bb), aa / (aa + noise) * bb / (bb + noise)
    return out


def test_the_pull_is_the_slope_of_the_likeness(device):
    """Against central differences of NCC between pictures that are known everywhere."""
    now, at, h = waves(), (0.4, -0.7), 0.02
    pull = expand(now, waves(), uniform(*at), device)[:2]
    ncc, weight = likeness(now, waves(at))
    for axis, step in enumerate(((h, 0), (0, h))):
        ahead, behind = (likeness(now, waves(np.add(at, sign * np.array(step))))[0] for sign in (1, -1))
        expected = weight * ncc * (ahead - behind) / (2 * h)
        np.testing.assert_allclose(pull[axis][NEAR, NEAR], expected[NEAR, NEAR], atol=0.01)
    assert np.abs(pull[:, NEAR, NEAR]).max() > 0.1


def test_the_stiffness_is_the_curvature_at_the_match(device):
    """Where pictures agree the Gauss-Newton matrix is the second derivative of 1 - NCC.

    The cubic's slope at a pixel is a central difference, which is 4 per cent less than these waves' own.
    """
    now, h = waves(), 0.05
    expansion = expand(now, now, uniform(0, 0), device)
    _, weight = likeness(now, now)

    def fall(u, v):
        return 1 - likeness(now, waves((u, v)))[0]

    uu = (fall(h, 0) + fall(-h, 0)) / h**2
    vv = (fall(0, h) + fall(0, -h)) / h**2
    uv = (fall(h, h) - fall(h, -h) - fall(-h, h) + fall(-h, -h)) / (4 * h**2)
    for found, expected in zip(expansion[2:], (uu, uv, vv), strict=True):
        np.testing.assert_allclose(found[NEAR, NEAR], (weight * expected)[NEAR, NEAR], rtol=0.1, atol=0.01)


def test_equal_pictures_pull_nowhere(device):
    """Exactly: this is what keeps a still shot still."""
    rng = np.random.default_rng(0)
    for picture in (rng.random(SIZE), waves(), np.zeros(SIZE)):
        assert not expand(picture, picture, uniform(0, 0), device)[:2].any()


@pytest.mark.parametrize(("gain", "offset"), [(0.5, 0.0), (1.0, 0.2), (0.7, 0.1)])
def test_gain_and_offset_pull_nowhere(device, gain, offset):
    """NCC does not see them."""
    now = waves()
    found = expand(now, gain * now + offset, uniform(0, 0), device)
    assert np.abs(found[:2]).max() < 2e-3
    assert found[2, NEAR, NEAR].max() > 0.05


def test_what_has_no_structure_has_no_say(device):
    """Beside a picture with structure, in either place."""
    flat = np.full(SIZE, 0.3)
    for pair in ((flat, waves()), (waves(), flat)):
        assert np.abs(expand(*pair, uniform(0, 0), device)).max() < 1e-3


def test_what_contradicts_has_no_say(device):
    """The likeness is truncated; and nothing is known outside of the picture."""
    assert not expand(waves(), 1 - waves(), uniform(0, 0), device).any()
    assert not expand(waves(), waves(), uniform(100, 0), device).any()

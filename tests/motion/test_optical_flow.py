"""Motion between two pictures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from warpfluid.motion.optical_flow import METHODS, optical_flow

SIZE = (96, 72)


def flame(seed=0, margin=16):
    """A textured flame with a margin around the picture, light 0 to 1."""
    rng = np.random.default_rng(seed)
    shape = tuple(length + 2 * margin for length in SIZE)
    grains = [ndimage.gaussian_filter(rng.standard_normal(shape), grain) * grain**1.6 for grain in (1, 2, 4)]
    texture = sum(grains) / np.std(sum(grains))
    u, v = ((np.arange(n) - n / 2) / wide for n, wide in zip(shape, SIZE, strict=True))
    return np.clip(0.5 + 0.2 * texture, 0, 1) * np.exp(-8 * (u[:, None] ** 2 + v[None] ** 2))


def eddies(speed):
    """A rising, turning flow with a mean displacement."""
    u, v = np.indices(SIZE) / np.reshape(SIZE, (2, 1, 1)) - 0.5
    flow = np.stack([-2.0 * v + 0.3 * np.sin(9 * v), 2.0 * u + 0.6])
    return flow * speed / np.hypot(*flow).mean()


def moved_pair(flow, change, seed=0):
    """A picture, the next one, and where there is flame; under a change both have noise."""
    wide, margin = flame(seed), 16
    later = wide[margin:-margin, margin:-margin]
    now = ndimage.map_coordinates(wide, np.indices(SIZE) + margin + flow, order=5)
    lit = now > 0.08
    if change:
        rng = np.random.default_rng(seed + 100)
        now, later = now + 2 / 255 * rng.standard_normal(SIZE), 0.88 * later + 0.02
        later = later + 2 / 255 * rng.standard_normal(SIZE)
    return np.clip(now, 0, 1).astype(np.float32), np.clip(later, 0, 1).astype(np.float32), lit


def error(found, flow, lit):
    """Mean endpoint error."""
    return np.hypot(*(found - flow))[lit].mean()


@pytest.mark.parametrize(("change", "bound"), [(False, 0.15), (True, 0.35)])
def test_finds_eddies(device, change, bound):
    """Four pixels of turning motion; where brightness changes the two others are misled."""
    flow = eddies(4.0)
    now, later, lit = moved_pair(flow, change)
    errors = {
        method: error(optical_flow(now, later, method=method, white=1.0, device=device), flow, lit)
        for method in METHODS
    }
    assert errors["nltv-ncc"] < bound
    if change:
        assert errors["nltv-ncc"] < 0.7 * min(errors["ilk"], errors["tvl1"])


@given(u=st.floats(-3, 3), v=st.floats(-3, 3), gain=st.floats(0.6, 1.0), seed=st.integers(0, 99))
@settings(max_examples=5)
def test_finds_a_shift_whatever_the_gain(u, v, gain, seed):
    """Uniform motion of any direction, the later picture darker."""
    flow = np.broadcast_to(np.reshape([u, v], (2, 1, 1)), (2, *SIZE))
    now, later, lit = moved_pair(flow, False, seed)
    found = optical_flow(now, gain * later, method="nltv-ncc", white=1.0, device="cpu")
    assert error(found, flow, lit) < 0.1 + 0.05 * np.hypot(u, v)


def test_white_is_a_scale(device):
    """The same pictures in other units move alike."""
    now, later, _ = moved_pair(eddies(2.0), False)
    small = optical_flow(now, later, method="nltv-ncc", white=1.0, device=device)
    large = optical_flow(1024 * now, 1024 * later, method="nltv-ncc", white=1024.0, device=device)
    np.testing.assert_array_equal(small, large)


def test_what_is_still_does_not_move(device):
    """Equal pictures give exactly zero, black ones and flat ones too."""
    now, _, _ = moved_pair(eddies(2.0), False)
    for picture in (now, np.zeros_like(now), np.full_like(now, 0.4)):
        assert not optical_flow(picture, picture, method="nltv-ncc", white=1.0, device=device).any()


def test_a_brighter_still_picture_does_not_move(device):
    """Where a picture only grows brighter the likeness is the greatest at rest."""
    now, _, lit = moved_pair(eddies(2.0), False)
    found = optical_flow(0.7 * now, now, method="nltv-ncc", white=1.0, device=device)
    assert np.hypot(*found)[lit].mean() < 0.02


@pytest.mark.parametrize("which", ["now", "later"])
def test_what_appears_or_is_gone_moves_little(device, which):
    """Nothing can be compared with black: no garbage."""
    picture, _, _ = moved_pair(eddies(2.0), False)
    black = np.zeros_like(picture)
    pair = (picture, black) if which == "now" else (black, picture)
    assert np.abs(optical_flow(*pair, method="nltv-ncc", white=1.0, device=device)).max() < 3


def test_the_dark_follows_what_is_near(device):
    """Around a moving puff the flow is smooth and no greater than the puff's own."""
    at = np.indices(SIZE) - np.reshape([48, 36], (2, 1, 1))
    rng = np.random.default_rng(3)
    texture = 1 + 0.4 * ndimage.gaussian_filter(rng.standard_normal(SIZE), 2) * 7
    now = np.clip(np.exp(-(at**2).sum(0) / 150) * texture * 0.6, 0, 1) * ((at**2).sum(0) < 500)
    later = np.roll(now, (2, 3), axis=(0, 1))
    flow = optical_flow(now, later, method="nltv-ncc", white=1.0, device=device)
    lit = now > 0.1
    np.testing.assert_allclose(np.median(flow[:, lit], axis=1), [2, 3], atol=0.1)
    assert np.hypot(*flow).max() < 1.5 * np.hypot(2, 3)
    assert np.abs(np.diff(flow, axis=1)[:, :20]).max() < 0.5


@pytest.mark.parametrize("size", [(8, 8), (9, 40), (65, 33)])
def test_sizes(device, size):
    """Small, odd and narrow pictures; the result has their shape and is finite."""
    rng = np.random.default_rng(1)
    now, later = rng.random((2, *size), np.float32)
    flow = optical_flow(now, later, method="nltv-ncc", white=1.0, device=device)
    assert flow.shape == (2, *size)
    assert np.isfinite(flow).all()


def test_the_same_bits_every_time(device):
    """No order of threads shows."""
    now, later, _ = moved_pair(eddies(4.0), True)
    first, second = (optical_flow(now, later, method="nltv-ncc", white=1.0, device=device) for _ in range(2))
    np.testing.assert_array_equal(first, second)

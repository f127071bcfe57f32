"""Advection against SciPy's spline, and identities."""

import numpy as np
import pytest
import warp as wp
from scipy.ndimage import gaussian_filter, map_coordinates

from warpfluid.kernels.advection import advect


def blobs(shape, seed=0):
    """A smooth non-negative field with an empty rim."""
    rng = np.random.default_rng(seed)
    inner = gaussian_filter(rng.standard_normal([n - 12 for n in shape]), 1).clip(0)
    return np.pad(inner, 6).astype(np.float32)


def moved(field, velocity, device, time_step=1.0):
    parts = [wp.array(np.broadcast_to(v, field.shape), dtype=float, device=device) for v in velocity]
    return advect(wp.array(field, dtype=float, device=device), *parts, time_step=time_step).numpy()


def clamped_spline(field, source):
    """SciPy's cubic spline, kept within the eight voxels around the source."""
    value = map_coordinates(field.astype(np.float64), source, order=3, mode="constant")
    padded, cell = np.pad(field, 20), [np.floor(s).astype(int) + 20 for s in source]
    corners = [padded[cell[0] + i, cell[1] + j, cell[2] + k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return np.clip(value, np.min(corners, axis=0), np.max(corners, axis=0))


@pytest.mark.parametrize("velocity", [(1.3, -2.45, 0.7), (0.5, 0.5, 0.5), (-3.9, 0.1, 2.2)])
def test_agrees_with_scipy_in_uniform_motion(velocity, device):
    """A clamped cubic spline read where the fluid came from."""
    field = blobs((30, 27, 53))
    source = [x - v for x, v in zip(np.indices(field.shape).astype(float), velocity, strict=True)]
    expected = clamped_spline(field, source)
    np.testing.assert_allclose(moved(field, velocity, device), expected, atol=2e-6)


def test_rest_and_whole_steps_are_exact(device):
    """No motion changes nothing; whole voxels shift the field."""
    field = blobs((26, 25, 60))
    np.testing.assert_allclose(moved(field, (0, 0, 0), device), field, atol=1e-6)
    shifted = moved(field, (2, -1, 3), device)
    np.testing.assert_allclose(shifted[2:, :-1, 3:], field[:-2, 1:, :-3], atol=1e-6)


def test_never_overshoots(device):
    """A sharp box stays between its two values in a swirling velocity, and what is empty stays empty."""
    field = np.zeros((24, 24, 20), np.float32)
    field[8:16, 8:16, 6:14] = 3
    x, z, _ = np.indices(field.shape) - 11.5
    out = moved(field, (0.2 * z, -0.2 * x, 0.3 * np.ones_like(x)), device)
    assert out.min() >= 0
    assert out.max() <= 3
    assert out.max() > 2.9


def test_rotation_keeps_more_than_linear_interpolation(device):
    """A blob turned by 90 degrees in 24 steps: its error is under a quarter of linear interpolation's."""
    n, steps = 40, 24
    middle = np.array([(n - 1) / 2, (n - 1) / 2, 0]).reshape(3, 1, 1, 1)
    x, z, up = np.indices((n, n, 8)) - middle
    angle = 0.5 * np.pi / steps
    spline = linear = np.exp(-((x - 9) ** 2 + z**2) / 18).astype(np.float32)
    source = np.array([x * np.cos(angle) + z * np.sin(angle), z * np.cos(angle) - x * np.sin(angle), up]) + middle
    for _ in range(steps):
        spline = moved(spline, (-angle * z, angle * x, np.zeros_like(x)), device)
        linear = map_coordinates(linear, source, order=1)
    expected = np.exp(-(x**2 + (z - 9) ** 2) / 18)
    ours, theirs = (np.abs(field - expected)[..., 2:-2].max() for field in (spline, linear))
    assert ours < 0.25 * theirs


def test_a_time_step_scales_the_motion(device):
    """Half the step at twice the speed goes as far."""
    field = blobs((24, 24, 30))
    np.testing.assert_allclose(
        moved(field, (2, 1, -1), device, time_step=0.5), moved(field, (1, 0.5, -0.5), device), atol=1e-6
    )

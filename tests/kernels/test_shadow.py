"""Shadows against the law of Beer and Lambert, and against rays that are followed one by one."""

import numpy as np
import pytest
import warp as wp
from scipy.ndimage import map_coordinates

from warpfluid.kernels.light.shadow import shadow

DIRECTIONS = [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.3, 0.5, 0.9), (-0.3, 0.5, -0.9), (1, 0.4, -0.2), (0.2, -1, 0.5)]


def shaded(extinction, direction, device="cpu", **options):
    return shadow(wp.array(extinction, dtype=float, device=device), direction, **options).numpy()


def marched(extinction, direction):
    """Transmittance of every voxel's own ray, by the trapezoid rule at every plane across the main axis."""
    step = np.asarray(direction) / np.abs(direction).max()
    here = np.indices(extinction.shape).astype(float)
    depth = 0.5 * extinction.astype(float)
    for j in range(1, max(extinction.shape) + 2):
        at = here + j * step[:, None, None, None]
        depth += map_coordinates(extinction.astype(float), at, order=1, mode="grid-constant")
    return np.exp(-np.linalg.norm(step) * depth)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_homogeneous_box(direction, device):
    """exp(-extinction distance); only where a ray leaves through an edge of the box is it off by some hundredths."""
    shape, extinction = (37, 21, 52), 0.03
    towards = np.asarray(direction) / np.linalg.norm(direction)
    here = np.stack(np.indices(shape), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.where(towards > 0, (np.array(shape) - 0.5 - here) / towards, (-0.5 - here) / towards)
    distance = np.where(towards == 0, np.inf, sides).min(axis=-1)
    error = np.abs(shaded(np.full(shape, extinction), direction, device) - np.exp(-extinction * distance))
    assert error.max() < 0.04
    assert np.quantile(error, 0.98) < 0.015
    if np.count_nonzero(direction) == 1:
        assert error.max() < 1e-6


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_smooth_cloud(direction, device):
    """As rays that are followed one by one, also in a box of odd sizes."""
    x, z, y = np.indices((33, 40, 49)) - np.array([15, 18, 25])[:, None, None, None]
    cloud = 0.4 * np.exp(-(x**2 + z**2 + y**2) / 60)
    error = np.abs(shaded(cloud, direction, device) - marched(cloud.astype(np.float32), direction))
    assert error.max() < 0.02


def test_soft_shadow_keeps_its_darkness():
    """What a small dense thing takes from the light is the same at every plane behind it."""
    x, z, y = np.indices((40, 40, 90)) - np.array([20, 20, 80])[:, None, None, None]
    thing = 5 * np.exp(-(x**2 + z**2 + y**2) / 8)
    lost = (1 - shaded(thing, (0.2, 0.1, 1.0))).sum(axis=(0, 1))
    np.testing.assert_allclose(lost[10:70], lost[70], rtol=0.03)


def test_spacing_is_the_edge_of_a_voxel():
    """As if all extinction were that much stronger."""
    cloud = np.random.default_rng(0).random((9, 8, 20), np.float32)
    np.testing.assert_allclose(shaded(cloud, (1, 2, 3), spacing=2), shaded(2 * cloud, (1, 2, 3)), rtol=1e-5)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 5, 60), (9, 1, 3), (8, 16, 97)])
def test_empty_and_tiny(shape, device):
    """Nothing hides nothing; a single voxel half hides itself."""
    assert (shaded(np.zeros(shape), (1, 2, 3), device) == 1).all()
    voxel = np.zeros(shape)
    voxel[0, 0, 0] = 1
    assert shaded(voxel, (0, 0, 1), device)[0, 0, 0] == pytest.approx(np.exp(-0.5), rel=1e-6)


def test_any_number_of_threads(monkeypatch):
    """The same bits."""
    cloud = np.random.default_rng(0).random((30, 31, 100), np.float32)
    found = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        found += [[shaded(cloud, direction) for direction in DIRECTIONS]]
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("direction", [(0, 0, 0), (1, np.nan, 0), (1, 2)])
def test_no_direction(direction):
    """A light that is nowhere is refused."""
    with pytest.raises(ValueError, match="direction"):
        shaded(np.zeros((2, 2, 2)), direction)

"""Where a fluid and a volume have come apart, against NumPy and SciPy."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.blur import blur
from warpfluid.kernels.fluid.disagreement import HIGH, LOW, SMOOTHING, quicken

SHAPE = (20, 18, 32)


def quickened(device, density, volume, share=0.5, **options):
    fields = (wp.array(np.asarray(f, np.float32), dtype=float, device=device) for f in (density, volume))
    return quicken(wp.full(SHAPE, share, dtype=float, device=device), *fields, **options).numpy()


@pytest.fixture
def pair():
    """A field, and one that it goes over into along the first axis."""
    rng = np.random.default_rng(3)
    a, b = rng.random((2, *SHAPE)).astype(np.float32) ** 4
    part = np.linspace(0, 1, SHAPE[0], dtype=np.float32)[:, None, None]
    return a, (1 - part) * a + part * b


@pytest.mark.parametrize("amounts", [True, False])
def test_follows_the_formula(device, pair, amounts):
    """A smooth step of the mean difference over the mean sum."""
    smooth = [blur(wp.array(f, dtype=float), SMOOTHING).numpy() for f in (abs(pair[0] - pair[1]), *pair)]
    apart = (smooth[0] - (0 if amounts else abs(smooth[1] - smooth[2]))) / (smooth[1] + smooth[2])
    t = np.clip((apart - LOW) / (HIGH - LOW), 0, 1)
    found = quickened(device, *pair, factor=1.8, amounts=amounts)
    np.testing.assert_allclose(found, 0.5 * (1 + 0.8 * t * t * (3 - 2 * t)), atol=1e-5)
    assert np.ptp(found) > 0.2


def test_what_agrees_is_mixed_as_before(device, pair):
    """Equal fields, and empty ones, change nothing; no more than all is ever taken."""
    assert (quickened(device, pair[0], pair[0], factor=2.0) == 0.5).all()
    assert (quickened(device, np.zeros(SHAPE), np.zeros(SHAPE), factor=2.0) == 0.5).all()
    assert quickened(device, *pair, share=0.9, factor=5.0).max() == 1


def test_matter_that_an_edit_makes_is_not_taken(device, pair):
    """Where one of both is empty they disagree in amount alone."""
    nothing = np.zeros(SHAPE)
    assert (quickened(device, pair[0], nothing, factor=2.0) == 1).all()
    np.testing.assert_allclose(quickened(device, pair[0], nothing, factor=2.0, amounts=False), 0.5, atol=1e-6)

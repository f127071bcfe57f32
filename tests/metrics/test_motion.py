"""Motion: what a known motion leaves is nothing, what flickers is told by how much."""

import numpy as np
import pytest
from scipy import ndimage

from warpfluid.metrics import left_over

NOW = ndimage.gaussian_filter(np.random.default_rng(0).random((40, 30)), 2, mode="wrap")


def still(shape=NOW.shape):
    return np.zeros((2, *shape))


def test_a_known_motion_leaves_nothing():
    """A picture moved by whole pixels, told so, leaves only its border."""
    later = np.roll(NOW, (3, -2), (0, 1))
    back = still()
    back[0], back[1] = -3, 2
    inner = np.s_[4:-4, 4:-4]
    masked = np.zeros_like(NOW)
    masked[inner] = later[inner]
    moved_too = ndimage.map_coordinates(NOW, np.indices(NOW.shape) + back, order=1, mode="nearest")
    np.testing.assert_allclose(moved_too[inner], later[inner], atol=1e-12)
    assert left_over(NOW, later, back) < 0.3 * left_over(NOW, later, still())


def test_flicker_is_told_by_how_much():
    """A picture that is brighter by a fifth of itself leaves a sixth of the brighter one."""
    assert left_over(NOW, 1.2 * NOW, still()) == pytest.approx(0.2 / 1.2)
    assert left_over(NOW, NOW, still()) == 0
    assert left_over(NOW, 0 * NOW, still()) == 0


def test_shapes_must_fit():
    """Pictures of unequal size are named."""
    with pytest.raises(ValueError, match=r"\(40, 30\), \(40, 29\) and \(2, 40, 30\)"):
        left_over(NOW, NOW[:, 1:], still())

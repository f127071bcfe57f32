"""What a simulated frame leaves on disk."""

import numpy as np
import pytest
from scipy.ndimage import maximum_filter

from warpfluid.simulation.written import widen


@pytest.mark.parametrize("shape", [(3, 9, 20), (1, 2, 4), (17, 5, 8)])
@pytest.mark.parametrize("voxels", [1, 2])
def test_widened_mask_is_its_maximum_over_a_box(shape, voxels):
    """At the border, too; and the mask itself stays as it is."""
    mask = np.random.default_rng(0).random(shape) < 0.05
    before = mask.copy()
    np.testing.assert_array_equal(widen(mask, voxels), maximum_filter(mask, 2 * voxels + 1))
    np.testing.assert_array_equal(mask, before)

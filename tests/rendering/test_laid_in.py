"""Bodies in a turntable: light in front of them is added, light behind is hidden."""

import numpy as np
import pytest
from solids import MIDDLE, SHAPE, box

from warpfluid.rendering.turntable import render_turntable


@pytest.mark.parametrize("angle", [0.0, 40.0])
def test_turntable_beside_a_body_is_unchanged(angle, fire):
    """To the bit, where no body stands."""
    plain = render_turntable(fire, [angle])[0]
    drawn = render_turntable(fire, [angle], surfaces=[box((8, 6, 8), (24, 8, 24))])[0]
    assert (drawn != plain).any()
    np.testing.assert_array_equal(drawn[:30], plain[:30])


def test_turntable_hides_light_behind_and_not_in_front():
    """A body between two sheets of light, one twice as bright as the other."""
    volume = np.zeros(SHAPE, np.float32)
    volume[:, 6], volume[:, 25] = 50, 100
    for angle, expected in ((0.0, 100), (180.0, 50)):
        picture = render_turntable(volume, [angle], "gray", surfaces=[box((10, 10, 10), MIDDLE, (0, 0, 0))])[0]
        np.testing.assert_allclose(picture[24, 26:38].astype(float), expected, atol=2)
        np.testing.assert_allclose(picture[2, 26:38].astype(float), 150, atol=2)

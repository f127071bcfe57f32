"""The colour of hot bodies against tables."""

import numpy as np
import pytest

from warpfluid.rendering.blackbody import LUMINANCE, XYZ_TO_RGB, blackbody_color

# CIE 1931 x, y of Planck's law by the tabulated observer; below 2000 K screens cannot show it.
KNOWN = {
    2000: (0.5267, 0.4133, 0.004),
    2500: (0.4770, 0.4137, 0.004),
    3000: (0.4369, 0.4041, 0.003),
    5000: (0.3451, 0.3516, 0.003),
    6500: (0.3135, 0.3237, 0.003),
}


@pytest.mark.parametrize(("kelvin", "x", "y", "tolerance"), [(k, *v) for k, v in KNOWN.items()])
def test_chromaticity(kelvin, x, y, tolerance):
    """Of the colour that is shown, back in the observer's space."""
    xyz = np.linalg.solve(XYZ_TO_RGB, blackbody_color([kelvin])[0])
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), (x, y), atol=tolerance)


@pytest.mark.parametrize(
    ("kelvin", "x", "y", "tolerance"), [(1000, 0.6528, 0.3444, 0.012), (1500, 0.5857, 0.3931, 0.006)]
)
def test_deep_red_is_the_nearest_that_screens_show(kelvin, x, y, tolerance):
    """Red and green are those of the table; the blue, which would be below 0, is 0."""
    table = XYZ_TO_RGB @ np.array([x, y, 1 - x - y])
    red, green, blue = blackbody_color([kelvin])[0]
    assert table[2] < 0 == blue
    assert green / red == pytest.approx(table[1] / table[0], abs=4 * tolerance)


def test_luminance_is_one():
    kelvin = np.linspace(800, 12000, 40)
    np.testing.assert_allclose(blackbody_color(kelvin) @ LUMINANCE, 1, rtol=1e-12)


def test_hotter_is_less_red():
    color = blackbody_color(np.linspace(1000, 10000, 50))
    assert (np.diff(color[:, 0]) < 0).all()
    assert (np.diff(color[:, 2]) >= 0).all()
    assert (color >= 0).all()


def test_white_of_the_screen_is_near_6500_kelvin():
    np.testing.assert_allclose(blackbody_color([6504])[0], 1, atol=0.05)  # daylight is a little greener


def test_cold_bodies_do_not_underflow():
    assert np.isfinite(blackbody_color([100.0, 500.0])).all()

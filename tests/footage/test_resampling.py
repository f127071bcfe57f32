"""Pictures moved by parts of pixels: whole pixels exactly, light kept, nothing new beside what was there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from warpfluid.footage.resampling import move


def wisps(rows=40, columns=30, margin=8):
    """Smooth light on black that stays away from the edges."""
    noise = ndimage.gaussian_filter(np.random.default_rng(1).standard_normal((rows, columns)), 1.5)
    light = np.maximum(noise, 0) * 300
    light[:margin] = light[-margin:] = 0
    light[:, :margin] = light[:, -margin:] = 0
    return light.astype(np.float32)


def test_nothing_to_do_does_nothing():
    """The very same picture comes back."""
    picture = wisps()
    assert move(picture, 0.0, 1.0) is picture


@given(st.integers(-7, 7))
def test_whole_pixels_keep_their_values(shift):
    """Up is towards the first row."""
    picture = wisps()
    np.testing.assert_array_equal(move(picture, shift, 1.0), np.roll(picture, -shift, axis=0))


@given(st.floats(-6, 6))
def test_light_is_kept(shift):
    """A shift neither adds light nor takes any, and goes where it should."""
    picture = wisps()
    moved = move(picture, shift, 1.0)
    assert moved.sum(dtype=np.float64) == pytest.approx(picture.sum(dtype=np.float64), rel=2e-5)
    centres = [np.average(np.arange(40), weights=p.sum(axis=1)) for p in (picture, moved)]
    assert centres[0] - centres[1] == pytest.approx(shift, abs=0.05)


@given(st.floats(-6, 6), st.floats(0.9, 1.1))
def test_nothing_new(shift, scale):
    """There is no ringing: black stays black, nothing is negative, and peaks grow by next to nothing."""
    picture = np.zeros((40, 30), np.float32)
    picture[15:25, 10:20] = 200
    moved = move(picture, shift, scale)
    assert moved.min() == 0
    assert moved.max() < 200 * 1.02
    rows, columns = np.nonzero(moved > 0)
    half = 5 * scale + 1
    assert abs(rows - (19.5 + -shift)).max() <= half
    assert abs(columns - 14.5).max() <= half


@given(st.floats(0.9, 1.1))
def test_enlarging_keeps_brightness(scale):
    """Areas grow with the square of the scale, levels stay."""
    picture = wisps()
    assert move(picture, 0.0, scale).sum() / picture.sum() == pytest.approx(scale**2, rel=0.01)
    np.testing.assert_allclose(move(np.full((20, 30), 7, np.float32), 1.3, scale), 7, rtol=1e-6)


def test_fine_detail_survives():
    """Half a pixel and back leaves more than linear interpolation does."""
    picture = wisps()
    cubic = move(move(picture, 0.5, 1.0), -0.5, 1.0)
    linear = ndimage.shift(ndimage.shift(picture, (-0.5, 0), order=1), (0.5, 0), order=1)
    assert np.abs(cubic - picture).sum() < 0.6 * np.abs(linear - picture).sum()

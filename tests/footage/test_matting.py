"""From a picture in a file to an image of light on black: each step against its definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage import transform

from warpfluid.footage import matting
from warpfluid.footage.matting import Matting


@given(st.integers(1, 20), st.integers(1, 20), st.integers(1, 20), st.integers(1, 20))
def test_shrinking_keeps_the_mean(rows, columns, width, height):
    """Averages over areas add up to the whole, for any sizes."""
    picture = np.random.default_rng(rows * columns).random((rows, columns)).astype(np.float32)
    small = matting.shrink(picture, (width, height))
    assert small.shape == (height, width)
    assert small.mean() == pytest.approx(picture.mean(), rel=1e-5)


def test_shrinking_by_whole_numbers_averages_blocks():
    """By 2 and 3 it is what scikit-image calls a local mean."""
    picture = np.random.default_rng(0).random((12, 18)).astype(np.float32)
    expected = transform.downscale_local_mean(picture, (3, 2))
    np.testing.assert_allclose(matting.shrink(picture, (9, 4)), expected, rtol=1e-5)


def test_a_flat_picture_stays_flat():
    """No pixel of a grey picture darkens at an edge."""
    np.testing.assert_allclose(matting.shrink(np.full((31, 17), 5, np.float32), (7, 9)), 5, rtol=1e-6)


@pytest.mark.parametrize(
    ("curve", "encode"),
    [
        ("srgb", lambda x: np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)),
        ("rec709", lambda x: np.where(x < 0.018, 4.5 * x, 1.099 * x**0.45 - 0.099)),
        ("none", lambda x: x),
    ],
)
def test_tone_curves_are_undone(curve, encode):
    """Light put through the published curve comes back."""
    light = np.linspace(0, 1, 101)
    np.testing.assert_allclose(matting.undo_tone_curve(encode(light), curve), light, atol=2e-3)


def test_unknown_curve_is_refused():
    """The error names the curves there are."""
    with pytest.raises(ValueError, match="none, srgb or rec709"):
        matting.undo_tone_curve(np.zeros(3), "log")


def test_black_level_keeps_white():
    """White stays at 255, the black level goes to 0 and what is below it too."""
    picture = np.full((8, 8, 1), 0.2, np.float32)
    picture[0, 0], picture[0, 1] = 1.0, 51 / 255
    image = Matting(size=(8, 8), black_level=51.0).image(picture)
    assert image[0, 7] == pytest.approx(255)
    assert np.sort(image.ravel())[:-1].max() == pytest.approx(0, abs=1e-4)


def test_largest_component_drops_sparks():
    """A spark that touches nothing goes, one that touches at a corner stays."""
    picture = np.zeros((10, 10, 1), np.float32)
    picture[2:6, 2:6] = 0.5
    picture[6, 6] = 1
    picture[0, 9] = 1
    image = Matting(size=(10, 10), largest_component=True).image(picture)
    assert (image > 0).sum() == 17
    assert image[9, 9] == 0
    assert not Matting(size=(10, 10), largest_component=True).image(picture * 0).any()


def test_background_crop_and_turn():
    """The crop is taken in the picture's pixels, the background in the crop's, and v is up."""
    picture = np.zeros((12, 14, 3), np.float32) + 0.1
    picture[3, 5] = 0.6
    plate = Matting(size=(9, 8), crop=(9, 8, 4, 2)).light(np.zeros((12, 14, 3), np.float32) + 0.1)
    image = Matting(size=(9, 8), crop=(9, 8, 4, 2), background=plate).image(picture)
    assert image[1, 8 - 1 - 1] == pytest.approx(0.5 * 255, rel=1e-5)
    assert image.sum() == pytest.approx(0.5 * 255, rel=1e-4)


def test_rows_become_equal():
    """Views get the mean of their row sums; a dark row stays dark and the others keep their own mean."""
    images = np.random.default_rng(0).random((3, 9, 8)).astype(np.float32) * 100 + 50
    images[0, :, 3] = 0
    sums = images.sum(axis=1)
    equal = matting.equalize_rows(images).sum(axis=1)
    np.testing.assert_allclose(equal[:, :3], np.broadcast_to(sums[:, :3].mean(axis=0), (3, 3)), rtol=1e-5)
    assert equal[0, 3] == 0
    np.testing.assert_allclose(equal[1:, 3], sums[1:, 3].mean(), rtol=1e-5)


def test_rows_are_scaled_within_bounds():
    """A row a thousand times brighter than its counterpart is not forced onto it."""
    images = np.ones((2, 8, 8), np.float32) * 2
    images[1] *= 100
    ratios = matting.equalize_rows(images) / images
    assert ratios.max() == 4
    assert ratios.min() >= 0.25


@given(st.integers(8, 9999), st.integers(8, 9999), st.integers(0, 99), st.integers(0, 99))
def test_crop_and_resolution_are_read(width, height, left, top):
    """The texts of the command line give the numbers they name."""
    assert matting.parse_crop(f"{width}x{height}+{left}+{top}") == (width, height, left, top)
    assert matting.parse_resolution(f"{width}x{height}") == (width, height)
    assert matting.parse_resolution(f"{width}") == (width, None)


@pytest.mark.parametrize("text", ["", "10", "10x0+0+0", "10x10", "10x10+-1+0", "axb+0+0"])
def test_bad_crop_is_refused(text):
    """The error shows the form."""
    with pytest.raises(ValueError, match=r"WIDTHxHEIGHT\+LEFT\+TOP"):
        matting.parse_crop(text)


@pytest.mark.parametrize("text", ["", "x10", "10x", "-5", "10.5", "half", "0", "7", "0x7", "16x0", "16x7"])
def test_bad_resolution_is_refused(text):
    """The error shows the form."""
    with pytest.raises(ValueError, match="WIDTHxHEIGHT"):
        matting.parse_resolution(text)

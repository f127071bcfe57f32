"""Views: pictures as files hold them become images of light, and nothing else is let in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from warpfluid.views import Views

LUMINANCE = (0.2126, 0.7152, 0.0722)


def blank(count=2, u=9, v=8):
    return np.zeros((count, u, v), np.float32)


@given(
    arrays.arrays(np.uint8, st.tuples(st.integers(8, 12), st.integers(8, 12))),
    st.floats(-360, 360, allow_nan=False),
)
def test_pictures_return_as_they_came(picture, angle):
    """A uint8 picture is the same after it went to an image and back."""
    views = Views.from_pictures([picture], [angle])
    assert views.images.dtype == np.float32
    assert views.images.flags.c_contiguous
    np.testing.assert_allclose(views.pictures()[0], picture, atol=1e-4)


@given(
    arrays.arrays(np.float32, (8, 11, 3), elements=st.floats(0, 100, width=32)),
    st.floats(0.125, 4),
)
def test_luminance_is_that_of_rec709(picture, white):
    """Each pixel is the weighted sum of its channels, in units of white."""
    views = Views.from_pictures([picture], [0], white=white)
    expected = sum(weight * picture[..., i].astype(float) for i, weight in enumerate(LUMINANCE)) / white * 255
    np.testing.assert_allclose(views.pictures()[0], expected, rtol=1e-5, atol=1e-3)


def test_v_is_up_and_u_is_right():
    """The top right pixel of a picture is the last of both axes."""
    picture = np.zeros((8, 10), np.uint8)
    picture[0, 9] = 255
    assert Views.from_pictures([picture], [0]).images[0, 9, 7] == 255


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65535), (np.float32, 7), (int, 40)])
def test_white_follows_the_type(dtype, white):
    """The full range of image types, and the brightest value of all pictures for others, becomes 255."""
    dim, bright = np.zeros((8, 8), dtype), np.zeros((8, 8), dtype)
    dim[0, 0], bright[0, 0] = white // 2, white
    views = Views.from_pictures([dim, bright], [0, 90])
    assert views.images.max() == pytest.approx(255)
    assert views.images[0].max() == pytest.approx(255 * (white // 2) / white)


def test_alpha_and_single_channels():
    """A picture with alpha counts as its colours, and one channel as grey."""
    rng = np.random.default_rng(1)
    colours = rng.random((8, 9, 4)).astype(np.float32)
    with_alpha = Views.from_pictures([colours], [0], white=1).images
    np.testing.assert_array_equal(with_alpha, Views.from_pictures([colours[..., :3]], [0], white=1).images)
    grey = Views.from_pictures([colours[..., :1]], [0], white=1).images
    np.testing.assert_array_equal(grey, Views.from_pictures([colours[..., 0]], [0], white=1).images)


def test_warp_arrays_are_taken():
    """Anything with a numpy method will do."""

    class Device:
        def numpy(self):
            return blank() + 3

    assert Views(Device(), (0, 90)).images[1, 2, 3] == 3
    assert Views.from_pictures([Device().numpy()[0]], [0]).size == (8, 9)


def test_black_is_allowed():
    """A frame before the fire begins is black, in floats too."""
    assert Views.from_pictures([np.zeros((8, 8))], [0]).images.max() == 0


def test_row_sums_are_equal_in_all_views():
    """A volume turned about its axis keeps the light of each height: the identity that inspect rests on."""
    volume = turning_volume(24, 10)
    views = Views(np.stack([project(volume, angle) for angle in (0, 33, 90, 151)]), (0, 33, 90, 151))
    sums = views.row_sums()
    np.testing.assert_allclose(sums, np.broadcast_to(sums[0], sums.shape), rtol=1e-5)


@pytest.mark.parametrize(
    ("images", "angles", "message"),
    [
        (blank()[0], (0,), "shape"),
        (blank(0), (), "at least one view"),
        (blank(u=1), (0, 90), "1 x 8 pixels"),
        (blank() - 1, (0, 90), "negative"),
        (blank() + np.nan, (0, 90), "not numbers"),
        (blank() + np.inf, (0, 90), "infinite"),
        (blank(), (0,), "2 images came with 1"),
        (blank(), (0, np.nan), "angle nan"),
        (blank(), (10, 370), "same"),
        (blank(), (-90, 90), "mirror image"),
    ],
)
def test_refusals(images, angles, message):
    """What cannot be the views of one fluid is refused with the reason."""
    with pytest.raises(ValueError, match=message):
        Views(images, angles)


def test_refused_pictures():
    """Unlike sizes, odd channels and a white of 0 are refused by name."""
    small, large = np.zeros((8, 8)), np.zeros((8, 9))
    with pytest.raises(ValueError, match="8 x 8 and 9 x 8"):
        Views.from_pictures([small, large], [0, 90])
    with pytest.raises(ValueError, match=r"\(8, 8, 2\)"):
        Views.from_pictures([np.zeros((8, 8, 2))], [0])
    with pytest.raises(ValueError, match="found none"):
        Views.from_pictures([], [])
    with pytest.raises(ValueError, match="white"):
        Views.from_pictures([small], [0], white=0)
    with pytest.raises(ValueError, match="white"):
        Views(blank(), (0, 90), white=np.nan)


def test_nan_in_a_picture_is_named():
    """A float picture with a hole is refused, not spread over the others."""
    with pytest.raises(ValueError, match="not numbers"):
        Views.from_pictures([np.full((8, 8), np.nan)], [0])


def turning_volume(width, height):
    """A few blobs inside the cylinder that every view sees, shape (x, z, y)."""
    rng = np.random.default_rng(0)
    volume = np.zeros((width, width, height))
    reach = width // 4
    for _ in range(40):
        x, z = rng.integers(width // 2 - reach, width // 2 + reach, 2)
        volume[x, z, rng.integers(height)] += rng.random()
    return volume


def project(volume, angle_deg):
    """Add every voxel to the two pixels its centre falls between."""
    width = len(volume)
    across = np.arange(width) - (width - 1) / 2
    angle = np.radians(angle_deg)
    u = np.cos(angle) * across[:, None] + np.sin(angle) * across[None, :] + (width - 1) / 2
    low = np.clip(np.floor(u).astype(int), 0, width - 2)
    share = (u - low)[..., None]
    inside = ((u >= 0) & (u <= width - 1))[..., None]
    image = np.zeros((width, volume.shape[2]))
    np.add.at(image, low, volume * (1 - share) * inside)
    np.add.at(image, low + 1, volume * share * inside)
    return image

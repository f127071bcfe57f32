"""The cameras that options ask for."""

import numpy as np
import pytest

from warpfluid.options import CameraOptions, RenderOptions
from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.framing import cameras, decided, picture_size

SHAPE = (40, 30, 60)


def camera(shape=SHAPE, size=(200, 200), number=1.0, **choices):
    (found,) = cameras(CameraOptions(**{"projection": "perspective", **choices}), shape, size, number)
    return found


@pytest.mark.parametrize("size", [(200, 200), (320, 180), (90, 160)])
@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
@pytest.mark.parametrize("shape", [SHAPE, (64, 64, 20)])
def test_the_axis_of_the_box_and_its_width_fit(size, projection, shape):
    """What is in the middle of the box, from floor to top, and to its sides."""
    x, z, y = shape
    points = [((x - 1) / 2, h, (z - 1) / 2) for h in (-0.5, y - 0.5)]
    points += [((x - 1) / 2 + side * x / 2, (y - 1) / 2, (z - 1) / 2) for side in (-1, 1)]
    seen = camera(shape, size, projection=projection).project(np.array(points))
    assert (seen[:, 0] > -0.51).all()
    assert (seen[:, 0] < size[0] - 0.49).all()
    assert (seen[:, 1] > -0.51).all()
    assert (seen[:, 1] < size[1] - 0.49).all()


def test_the_level_orthographic_camera_is_the_projectors():
    ours, theirs = camera(size=(40, 60), projection="orthographic", angle=30), orthographic(SHAPE, 30)
    assert ours.pixel == theirs.pixel == 1
    points = np.random.default_rng(1).random((20, 3)) * 30
    np.testing.assert_allclose(ours.project(points)[:, :2], theirs.project(points)[:, :2])


def test_lengths_are_tenths_of_the_height():
    found = camera(distance=20, target="1,5,0")
    target = np.array([(40 - 1) / 2 + 6, 29.5, (30 - 1) / 2])
    np.testing.assert_allclose(found.eye + 120 * found.forward, target)


def test_zoom_enlarges_what_is_in_the_middle():
    near, far = camera(zoom=2), camera()
    assert near.pixel == far.pixel / 2
    np.testing.assert_array_equal(near.eye, far.eye)


def test_numbers_are_keyed():
    found = camera(number=5, angle="1:0;9:90", elevation="1:0;9:60", zoom="1:1;9:3")
    constant = camera(angle=45, elevation=30, zoom=2)
    np.testing.assert_allclose(found.eye, constant.eye)
    np.testing.assert_allclose(found.up, constant.up)


def test_a_turn_adds_to_the_angle():
    (turned,) = cameras(CameraOptions(projection="perspective", angle=30), SHAPE, (10, 10), 1, 0.25)
    np.testing.assert_allclose(turned.eye, camera(size=(10, 10), angle=120).eye)


def test_both_eyes_see_the_target_in_one_place():
    options = CameraOptions(projection="perspective", stereo="separate", eye_distance=2)
    left, right = cameras(options, SHAPE, (64, 48), 1)
    target = np.array([[19.5, 29.5, 14.5]])
    np.testing.assert_allclose(left.project(target), right.project(target))
    assert np.linalg.norm(left.eye - right.eye) == pytest.approx(12)
    near = target + np.array([[0, 0, 10.0]])
    assert left.project(near)[0, 0] > right.project(near)[0, 0]


def test_eyes_side_by_side_have_half_of_the_width():
    options = CameraOptions(projection="perspective", stereo="side-by-side")
    assert [eye.size for eye in cameras(options, SHAPE, (64, 48), 1)] == [(32, 48), (32, 48)]


def test_size_of_the_picture():
    assert picture_size(SHAPE, (3, 5)) == (3, 5)
    assert picture_size(SHAPE, None) == (480, 720)
    assert picture_size((1, 1, 1000), None) == (2, 720)


@pytest.mark.parametrize(
    ("mode", "asked", "found"),
    [("sum", "auto", "orthographic"), ("lit", "auto", "perspective"), ("sum", "perspective", "perspective")],
)
def test_projection_is_decided(mode, asked, found):
    assert decided(CameraOptions(projection=asked), RenderOptions(mode=mode)).projection == found

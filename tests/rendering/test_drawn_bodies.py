"""Bodies in pictures: where the projector would put them, and which light they hide."""

import numpy as np
import pytest

from warpfluid.projector import Projector
from warpfluid.rendering.bodies import DrawnBody, draw_bodies, rasterize, render_with_bodies, share_in_front
from warpfluid.rendering.turntable import render_turntable
from warpfluid.simulation.triangles import box_surface

SHAPE = (32, 32, 24)
MIDDLE = np.array([15.5, 11.5, 15.5])


def box(size, centre, **options):
    vertices, triangles = box_surface(size)
    return DrawnBody(vertices + np.asarray(centre), triangles, **options)


def centroid(image):
    """Column and row of the centre of light."""
    rows, columns = np.indices(image.shape)
    return np.array([(columns * image).sum(), (rows * image).sum()]) / image.sum()


@pytest.mark.parametrize("angle", [0, 30, 90, 135, 180, 250])
def test_stands_where_the_projector_sees_it(angle):
    """The same voxel as a light and as a body."""
    volume = np.zeros(SHAPE, np.float32)
    volume[24, 9, 5] = 1  # (x, z, y)
    seen = Projector([angle], SHAPE).project(volume)[0].T[::-1]
    layer = rasterize([box((1, 1, 1), (24, 5, 9))], angle, SHAPE, 8)
    at = (centroid(layer.cover) + 0.5) / 8 - 0.5
    np.testing.assert_allclose(at, centroid(seen), atol=0.1)


@pytest.mark.parametrize("angle", [0, 45, 90])
def test_covers_its_silhouette(angle):
    """A box turned by the camera's angle is as wide as its diagonal sides show."""
    t = np.deg2rad(angle)
    layer = rasterize([box((6, 5, 4), MIDDLE)], angle, SHAPE, 4)
    expected = 5 * (6 * abs(np.cos(t)) + 4 * abs(np.sin(t)))
    assert layer.cover.sum() / 16 == pytest.approx(expected, rel=0.06)


def test_depth_is_the_nearest_side():
    """Half the box's depth in front of its middle, which is 3 voxels in front of the volume's."""
    layer = rasterize([box((6, 6, 4), MIDDLE + np.array([0, 0, 3]))], 0, SHAPE)
    assert np.unique(layer.depth[layer.cover == 1]) == pytest.approx(5.0)


def test_the_nearer_hides_the_farther():
    """In whatever order they are given, and the other way round from behind."""
    red = box((4, 4, 4), MIDDLE + np.array([0, 0, 8]), color=(1, 0, 0))
    blue = box((4, 4, 4), MIDDLE - np.array([0, 0, 8]), color=(0, 0, 1))
    for bodies in ([red, blue], [blue, red]):
        for angle, channel in ((0, 0), (180, 2)):
            color = rasterize(bodies, angle, SHAPE).color[12, 16]
            assert color[channel] > 0.2
            assert color[2 - channel] == 0


def test_light_behind_is_hidden_and_light_in_front_is_not():
    """A body between two sheets of light, one twice as bright as the other."""
    volume = np.zeros(SHAPE, np.float32)
    volume[:, 6], volume[:, 25] = 1, 2
    depth = rasterize([box((10, 10, 10), MIDDLE)], 0, SHAPE).depth
    for angle, share in ((0, 2 / 3), (180, 1 / 3)):
        shares = share_in_front(volume, depth, angle)
        np.testing.assert_allclose(shares[12, 12:19], share, atol=1e-5)
        assert shares[0, 0] == 1


@pytest.mark.parametrize("angle", [0.0, 40.0])
def test_no_body_changes_nothing(angle, fire):
    """The turntable's picture, to the bit; also where a body stands beside."""
    plain = render_turntable(fire, [angle])[0]
    np.testing.assert_array_equal(render_with_bodies(fire, [], angle), plain)
    drawn = render_with_bodies(fire, [box((8, 6, 8), (24, 8, 24))], angle)
    assert (drawn != plain).any()
    np.testing.assert_array_equal(drawn[:30], plain[:30])


def test_a_dark_body_in_front_is_dark(fire):
    """It hides all the fire that is behind it."""
    wall = box((60, 60, 2), (24, 20, 49), color=(0, 0, 0))
    assert not render_with_bodies(fire, [wall], 0.0).any()
    behind, plain = render_with_bodies(fire, [wall], 180.0), render_turntable(fire, [180.0])[0]
    # smoothing spreads a trace of light to rays that cross none, which is hidden
    assert np.abs(behind.astype(int) - plain).max() < 8


def test_over_a_finished_picture():
    """Opaque, of the picture's own scale."""
    picture = np.full((48, 64, 3), 200, np.uint8)
    drawn = draw_bodies(picture, [box((8, 8, 8), MIDDLE, color=(1, 0, 0))], 0, SHAPE)
    assert drawn[24, 32, 0] > 80
    assert not drawn[24, 32, 1:].any()
    assert (drawn[0] == 200).all()
    with pytest.raises(ValueError, match="multiple"):
        draw_bodies(picture[:-1], [], 0, SHAPE)

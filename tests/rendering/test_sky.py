"""A probe behind the picture: where its light stands, and how it is averaged."""

import numpy as np
import pytest

from warpfluid.rendering.camera import orthographic, perspective
from warpfluid.rendering.lighting import Lighting
from warpfluid.rendering.probe import light_from_probe, sphere
from warpfluid.rendering.sky import see_sky

SHAPE = (8, 8, 8)


def seen_from(angle, elevation=0.0, field_of_view=60.0, size=(41, 31)):
    return perspective(SHAPE, angle, elevation, distance=20, field_of_view_deg=field_of_view, size=size)


@pytest.mark.parametrize("angle", [0, 73, 180, -100])
@pytest.mark.parametrize("elevation", [0, 50, -80])
def test_every_ray_sees_its_direction(angle, elevation):
    """A probe that is a linear function of the direction, at a pixel of its own each: also across the seam."""
    directions, _ = sphere((360, 720))
    camera = seen_from(angle, elevation, size=(241, 181))
    towards = camera.rays()[1]
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    np.testing.assert_allclose(see_sky(1 + directions, camera), 1 + towards, atol=1e-3)


@pytest.mark.parametrize("rotation", [0, 30, 250])
def test_a_sun_is_seen_where_it_lights_from(rotation):
    """The brightest pixel lies where the lamp made of the same probe stands."""
    directions, _ = sphere((128, 256))
    probe = np.full((128, 256, 3), 0.01)
    probe[directions @ np.array([0.6, 0.48, 0.64]) > np.cos(np.deg2rad(3))] = 50
    lighting: Lighting = light_from_probe(probe, rotation_deg=rotation)
    (sun,) = lighting.suns
    angle = np.rad2deg(np.arctan2(sun.direction[0], -sun.direction[2]))
    sky = see_sky(probe, seen_from(angle, -np.rad2deg(np.arcsin(sun.direction[1]))), rotation_deg=rotation)[..., 0]
    rows, columns = np.nonzero(sky > 25)
    np.testing.assert_allclose([rows.mean(), columns.mean()], [15, 20], atol=0.6)


def test_what_is_finer_than_the_picture_is_averaged():
    """A chess board of single pixels is grey in a small picture; parallel rays see one point."""
    board = np.indices((512, 1024)).sum(axis=0)[..., None] % 2 * np.ones(3)
    assert np.abs(see_sky(board, seen_from(10, field_of_view=90, size=(40, 30))) - 0.5).max() < 0.05
    assert np.ptp(see_sky(board, orthographic(SHAPE, 30, 20))) == 0

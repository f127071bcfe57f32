"""Surfaces in a medium: its shadow and its fire on them, what they hide, and edges that show what is behind."""

import numpy as np
import pytest
import warp as wp
from solids import ABOVE, FURNACE, MIDDLE, SHAPE, box, camera_at, smoke

from warpfluid.rendering.camera import orthographic, perspective
from warpfluid.rendering.composing import render
from warpfluid.rendering.fires import ball_escape, find_fires
from warpfluid.rendering.harmonics import uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.shadows import light_volume
from warpfluid.rendering.surfaces import Ground, see


def test_smoke_darkens_what_is_below_it():
    """exp(-extinction height) of the sun comes through, beside the box all of it."""
    medium = smoke(1.0, 0.05, 0.0)
    lighting = Lighting((Sun(ABOVE, (np.pi,) * 3),))
    camera = orthographic(SHAPE, 0, 90, size=(64, 64), zoom=0.4)
    seen = see([], camera, lighting, ground=Ground(SHAPE, (1, 1, 1)), inner=light_volume(medium, lighting))
    assert seen.color[32, 32, 0] == pytest.approx(np.exp(-0.05 * 24), rel=0.03)
    assert seen.color[32, 4, 0] == pytest.approx(1, abs=1e-4)


def test_white_furnace_with_bodies():
    """Smoke that absorbs nothing, a white body: all of it as bright as the uniform light around."""
    cloud = np.random.default_rng(0).random(SHAPE)
    medium = smoke(cloud, 0.2, 1.0)
    camera = camera_at(30, 2, 20)
    picture = render(medium, camera, FURNACE, light_volume(medium, FURNACE), surfaces=[box((9, 6, 7), MIDDLE)])
    alone = render(medium, camera, FURNACE, light_volume(medium, FURNACE))
    np.testing.assert_allclose(alone.over(np.ones(3)), 1, atol=4e-3)
    np.testing.assert_allclose(picture.over(np.ones(3)), 1, atol=0.01)


def test_edges_show_what_is_behind():
    """At the edge of a body the picture is a mixture: no dark seam before bright fire."""
    medium = smoke(0.05, 1e-6, 0.0, emission=[0, 2])
    camera = camera_at(10, 2)
    plain, body = render(medium, camera, FURNACE), render(medium, camera, FURNACE, surfaces=[box((9, 9, 9), MIDDLE)])
    seen = see([box((9, 9, 9), MIDDLE)], camera, FURNACE, fires=find_fires(medium))
    whole = march(medium, camera, limits=seen.depth, lighting=FURNACE)
    edge = (seen.cover > 0) & (seen.cover < 1)
    assert edge.any()
    share = seen.cover[edge][:, None]
    expected = share * whole.color[edge] + (1 - share) * plain.color[edge] + seen.color[edge]
    np.testing.assert_allclose(body.color[edge], expected, rtol=1e-2)
    np.testing.assert_array_equal(body.color[seen.cover == 0], plain.color[seen.cover == 0])
    assert (body.alpha[seen.cover == 1] == 1).all()
    assert body.depth[48 // 2, 32] == seen.depth[24, 32]


def test_fire_lights_the_ground():
    """As a lamp: its light falls with the square of the distance, by the cosine; none is lost in gathering it."""
    glow = np.zeros(SHAPE)
    glow[14:18, 14:18, 16:20] = 1.0
    medium = smoke(glow, 0.0, 0.0, emission=[0, 3.0])
    fires = find_fires(medium)
    assert fires.escaping.sum(axis=0)[0] == pytest.approx(3 * 64, rel=1e-3)
    camera = orthographic(SHAPE, 0, 90, size=(100, 100), zoom=0.3)
    seen = see([], camera, Lighting(), ground=Ground(SHAPE, (1, 1, 1)), fires=fires)
    away = np.array([40.0, 0.0, 0.0])
    column, row, _ = camera.project(np.array([15.5, -0.5, 15.5]) + away)[0]
    height = 18.0
    expected = 192 * height / (height**2 + 1600) ** 1.5 / np.pi
    assert seen.color[round(row), round(column), 0] == pytest.approx(expected, rel=0.06)


@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 90, 5), (17, 2, 33)])
@pytest.mark.parametrize("density", [0.0, 1.0])
def test_odd_boxes(shape, density):
    """Empty or full, thin or a single voxel: a picture without holes."""
    medium = Medium(
        fields={"density": wp.full(shape, density, dtype=float)},
        extinction=Curve("density", 1.0, [0, 0.5]),
        emission=Curve("density", 1.0, [0, 1]),
        albedo=Curve("density", 1.0, [0.5]),
    )
    lighting = Lighting((Sun((1, 2, 3), (1, 1, 1)),), uniform((1, 1, 1)))
    camera = perspective(shape, 30, 20, distance=3 * max(shape), field_of_view_deg=30, size=(33, 17))
    picture = render(medium, camera, lighting, light_volume(medium, lighting), ground=Ground(shape))
    for layer in (picture.color, picture.alpha, picture.density, picture.emission):
        assert np.isfinite(layer).all()
    assert picture.color.max() > 0.2
    assert picture.emission.any() == (density > 0)
    assert not np.isnan(picture.depth).any()


def test_fires_are_few():
    """At most 24 lamps, and none of their light is lost; none where nothing glows."""
    glow = np.random.default_rng(0).random(SHAPE)
    medium = smoke(glow, emission=[[0, 0, 0], [3, 2, 0]])
    fires = find_fires(medium)
    assert len(fires.places) == 24
    np.testing.assert_allclose(fires.colors.sum(axis=0), glow.sum() * np.array([3, 2, 0]), rtol=1e-4)
    assert not len(find_fires(smoke(glow)).places)
    escape = ball_escape(np.array([0.0, 0.049, 0.051, 1.0, 30.0]))
    np.testing.assert_allclose(escape, [1, 0.964, 0.963, 0.527, 0.02499], atol=1e-3)
    assert not len(find_fires(smoke(0 * glow, emission=[0, 1])).places)

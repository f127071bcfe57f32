"""Surfaces where the projector would put them, lit by closed forms."""

import numpy as np
import pytest
from solids import FURNACE, MIDDLE, SHAPE, ball, box, camera_at, centroid

from warpfluid.projector import Projector
from warpfluid.rendering.camera import orthographic, perspective
from warpfluid.rendering.harmonics import irradiance, sky, uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.normals import corner_normals
from warpfluid.rendering.surfaces import Ground, see
from warpfluid.simulation.triangles import box_surface


@pytest.mark.parametrize("angle", [0, 30, 90, 135, 180, 250])
def test_stands_where_the_projector_sees_it(angle):
    """The same voxel as a light and as a body."""
    volume = np.zeros(SHAPE, np.float32)
    volume[24, 9, 5] = 1  # (x, z, y)
    seen = Projector([angle], SHAPE).project(volume)[0].T[::-1]
    cover = see([box((1, 1, 1), (24, 5, 9))], camera_at(angle, 8), FURNACE).cover
    np.testing.assert_allclose((centroid(cover) + 0.5) / 8 - 0.5, centroid(seen), atol=0.1)


def test_stands_where_the_camera_says():
    """In perspective, too, and as deep."""
    camera = perspective(SHAPE, 40, 25, distance=90, field_of_view_deg=25, size=(160, 120))
    place = np.array([20.0, 4.0, 12.0])
    seen = see([box((0.8, 0.8, 0.8), place)], camera, FURNACE)
    column, row, depth = camera.project(place)[0]
    np.testing.assert_allclose(centroid(seen.cover), [column, row], atol=0.1)
    assert np.median(seen.depth[seen.cover == 1]) == pytest.approx(depth, abs=0.7)
    assert np.isinf(seen.depth[seen.cover == 0]).all()


@pytest.mark.parametrize("angle", [0, 45, 90])
def test_covers_its_silhouette(angle):
    """A box turned by the camera's angle is as wide as its diagonal sides show."""
    t = np.deg2rad(angle)
    cover = see([box((6, 5, 4), MIDDLE)], camera_at(angle), FURNACE).cover
    expected = 5 * (6 * abs(np.cos(t)) + 4 * abs(np.sin(t)))
    assert cover.sum() / 16 == pytest.approx(expected, rel=0.02)


def test_the_nearer_hides_the_farther():
    """In whatever order they are given, and the other way round from behind."""
    red, blue = box((4, 4, 4), MIDDLE + np.array([0, 0, 8]), (1, 0, 0)), box((4, 4, 4), MIDDLE - [0, 0, 8], (0, 0, 1))
    for bodies in ([red, blue], [blue, red]):
        for angle, channel in ((0, 0), (180, 2)):
            color = see(bodies, camera_at(angle, 1), FURNACE).color[12, 16]
            assert color[channel] > 0.9
            assert color[2 - channel] == 0


def test_white_body_in_the_furnace(device):
    """In uniform light a white body is as bright as its surroundings, from everywhere."""
    for camera in (camera_at(20), camera_at(70, elevation=50)):
        seen = see([ball(8, MIDDLE)], camera, FURNACE, device=device)
        np.testing.assert_allclose(seen.color[seen.cover == 1], 1, atol=1e-4)


def test_sky_on_each_side():
    """The irradiance of the harmonics, over pi."""
    ambient = np.random.default_rng(0).uniform(-0.1, 0.1, (9, 3)) + uniform((1, 2, 3))
    for angle, elevation in ((0, 0), (90, 0), (180, 0), (270, 0), (0, 90), (0, -90)):
        camera = camera_at(angle, 1, elevation)
        seen = see([box((9, 9, 9), MIDDLE)], camera, Lighting((), ambient))
        np.testing.assert_allclose(seen.color[11, 15], irradiance(ambient, -camera.forward) / np.pi, rtol=1e-5)


def test_a_sun_on_a_ball():
    """Lambert's cosine, seen from where the sun is; smooth, though it is made of flat triangles."""
    camera = camera_at(0, 8)
    sun = Lighting((Sun(-camera.forward, (np.pi, 2 * np.pi, 0)),))
    seen = see([ball(8, MIDDLE, rings=20)], camera, sun)
    rows, columns = np.indices(seen.cover.shape)
    away = np.hypot((columns - 127.5) / 8, (rows - 95.5) / 8)
    inner = away < 7.2
    np.testing.assert_allclose(seen.color[inner, 0], np.sqrt(64 - away[inner] ** 2) / 8, atol=0.03)
    np.testing.assert_allclose(seen.color[..., 1], 2 * seen.color[..., 0], rtol=1e-5)


def test_shadow_of_a_box_on_the_ground():
    """Where the sun cannot reach: as large as the box, beside it by its height."""
    lighting = Lighting((Sun((1, 1, 0), (np.pi * np.sqrt(2),) * 3),))
    camera = orthographic(SHAPE, 0, 90, size=(640, 640), zoom=0.5)
    seen = see([box((4, 4, 4), (15.5, 9.5, 15.5))], camera, lighting, ground=Ground(SHAPE, (1, 1, 1)))
    pixel = camera.pixel**2
    dark = (seen.color[..., 0] < 0.5) & (seen.cover == 1)
    # 4 wide, and from 15.5 - 10 +- 2 -+ 2 in x: its left side is 8 wide, 4 of which lie below the box or beyond it
    assert dark.sum() * pixel == pytest.approx(4 * 8, rel=0.02)
    column, row, _ = camera.project([15.5 - 10, -0.5, 15.5])[0]
    np.testing.assert_allclose(centroid(dark.astype(float)), [column, row], atol=1.0)
    far = seen.color[(seen.cover == 1) & ~dark]
    np.testing.assert_allclose(np.median(far), 1, atol=0.01)


def test_bodies_hide_the_sky_from_the_ground():
    """Darkest where they meet it; an endless wall hides half."""
    wall = box((400, 400, 2), (15.5, 199, 15.5))
    camera = orthographic(SHAPE, 0, 90, size=(320, 320), target=(15.5, 0, 20))
    seen = see([wall], camera, FURNACE, ground=Ground(SHAPE, (1, 1, 1)))
    _, row, _ = camera.project([15.5, -0.5, 17.0])[0]
    assert seen.color[int(row) + 3, 140:180].mean() == pytest.approx(0.5, abs=0.06)


def test_ground_fades_and_is_no_ceiling():
    """It ends softly all around, and is not seen from below."""
    camera = orthographic(SHAPE, 0, 90, size=(200, 200), zoom=0.12)
    cover = see([], camera, FURNACE, ground=Ground(SHAPE)).cover
    assert cover[100, 100] == 1
    assert 0.2 < cover[100, 100 + int(60 / camera.pixel)] < 0.8
    assert cover[100, -1] == 0
    assert not see([], camera_at(0, 1, -40), FURNACE, ground=Ground(SHAPE)).cover.any()


def test_normals_are_smooth_or_sharp():
    """A box keeps its edges; a ball's normals point from its middle."""
    vertices, triangles = box_surface(np.array([1, 2, 3]))
    normals = corner_normals(vertices, triangles)
    assert (np.abs(normals).max(axis=-1) == 1).all()
    round_one = ball(5, (0, 0, 0), rings=24)
    corners = round_one.vertices[round_one.triangles]
    np.testing.assert_allclose((round_one.normals * corners).sum(axis=-1) / 5, 1, atol=0.02)


def test_any_number_of_threads(monkeypatch):
    """The same bits."""
    found = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        lighting = Lighting((Sun((1, 2, 1), (1, 1, 1)),), sky((1, 1, 1), (0, 0, 0)))
        found.append(see([ball(6, MIDDLE)], camera_at(30, 2, 20), lighting, ground=Ground(SHAPE)).color)
    np.testing.assert_array_equal(*found)

"""Surfaces where the projector would put them, lit by closed forms, before what they hide."""

import numpy as np
import pytest
import warp as wp

from warpfluid.projector import Projector
from warpfluid.rendering.camera import look_at, orthographic, perspective
from warpfluid.rendering.composing import render
from warpfluid.rendering.fires import ball_escape, find_fires
from warpfluid.rendering.harmonics import irradiance, sky, uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.normals import corner_normals
from warpfluid.rendering.shadows import light_volume
from warpfluid.rendering.surfaces import Ground, Surface, see
from warpfluid.rendering.turntable import render_turntable
from warpfluid.simulation.triangles import box_surface, turned_surface

SHAPE = (32, 32, 24)
MIDDLE = np.array([15.5, 11.5, 15.5])
FURNACE = Lighting((), uniform((1, 1, 1)))
ABOVE = (0.0, 1.0, 0.0)


def box(size, centre, color=(1.0, 1.0, 1.0)):
    vertices, triangles = box_surface(np.asarray(size))
    return Surface(vertices + np.asarray(centre), triangles, color)


def ball(radius, centre, color=(1.0, 1.0, 1.0), rings=60):
    angles = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)[1:-1]
    vertices, triangles = turned_surface(radius * np.cos(angles), radius * np.sin(angles), (-radius, radius), 120)
    return Surface(vertices + np.asarray(centre), triangles, color)


def camera_at(angle, scale=4, elevation=0.0):
    return orthographic(SHAPE, angle, elevation, size=(SHAPE[0] * scale, SHAPE[2] * scale))


def smoke(density, extinction=1.0, albedo=0.8, emission=None):
    field = np.broadcast_to(np.asarray(density, np.float32), SHAPE)
    return Medium(
        fields={"density": wp.array(field, dtype=float)},
        extinction=Curve("density", 1.0, [0, extinction]),
        albedo=Curve("density", 1.0, [albedo]),
        emission=Curve("density", 1.0, emission) if emission else None,
    )


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
    cover = see([box((1, 1, 1), (24, 5, 9))], camera_at(angle, 8), FURNACE).cover
    np.testing.assert_allclose((centroid(cover) + 0.5) / 8 - 0.5, centroid(seen), atol=0.1)


@pytest.mark.parametrize("make", [lambda p: p, lambda p: look_at(p.eye, MIDDLE, size=p.size, field_of_view_deg=30)])
def test_stands_where_the_camera_says(make):
    """In perspective, too, and as deep."""
    camera = make(perspective(SHAPE, 40, 25, distance=90, field_of_view_deg=25, size=(160, 120)))
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


def test_smoke_darkens_what_is_below_it():
    """exp(-extinction height) of the sun comes through, beside the box all of it."""
    medium = smoke(1.0, 0.05, 0.0)
    lighting = Lighting((Sun(ABOVE, (np.pi,) * 3),))
    camera = orthographic(SHAPE, 0, 90, size=(64, 64), zoom=0.4)
    seen = see([], camera, lighting, ground=Ground(SHAPE, (1, 1, 1)), inner=light_volume(medium, lighting))
    assert seen.color[32, 32, 0] == pytest.approx(np.exp(-0.05 * 24), rel=0.03)
    assert seen.color[32, 4, 0] == pytest.approx(1, abs=1e-4)


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

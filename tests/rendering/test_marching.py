"""The ray marcher against the projector, closed forms, and a slow march by SciPy."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from media import LINE, ONE, VIEWS, noise, on

from warpfluid.projector import Projector
from warpfluid.rendering.camera import Camera, orthographic, perspective
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.marching import march
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.stereo import stereo_pair

ANGLES = [0, 30, 45, 90, 117.3, -52, 180, 270]


@pytest.mark.parametrize("shape", [(23, 23, 17), (8, 8, 8), (1, 1, 1), (16, 16, 3)])
@pytest.mark.parametrize("angle", ANGLES)
def test_light_without_extinction_is_the_projectors_ray_sum(shape, angle, device):
    """To rounding, and so is the sum of the density."""
    volume = np.random.default_rng(1).random(shape, np.float32)
    blocks = np.random.default_rng(2).random([-(-n // 5) for n in shape]) > 0.5
    volume *= np.kron(blocks, np.ones((5, 5, 5)))[: shape[0], : shape[1], : shape[2]]
    expected = Projector([angle], shape, footprint="joseph", device=device).project(volume)[0].T[::-1]
    medium = Medium(fields={"density": on(device, volume)}, emission=Curve("density", 1, LINE[:, None] * [1, 2, 0.5]))
    picture = march(medium, orthographic(shape, angle))
    np.testing.assert_allclose(picture.color, expected[..., None] * [1, 2, 0.5], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(picture.density, expected, rtol=1e-5, atol=1e-5)
    np.testing.assert_array_equal(picture.emission, picture.color)
    np.testing.assert_array_equal(picture.alpha, 0)


@pytest.mark.parametrize("size", [(7, 7, 7), (24, 10, 15)])
@pytest.mark.parametrize("thickness", [1e-4, 0.3, 2.0])
def test_absorption_is_exponential(size, thickness, device):
    """A box of equal density is crossed by rays that keep exp(-sum), the background's share."""
    medium = Medium(
        fields={"density": on(device, np.full(size, 2.0))}, extinction=Curve("density", 2, thickness * LINE)
    )
    picture = march(medium, orthographic(size, 0))
    np.testing.assert_allclose(picture.alpha, 1 - np.exp(-thickness * size[1]), rtol=1e-5)
    np.testing.assert_allclose(picture.over(3.0), 3 * np.exp(-thickness * size[1]), rtol=1e-4, atol=1e-6)
    np.testing.assert_array_equal(picture.color, 0)


def test_a_glowing_box_comes_to_its_own_brightness(device):
    """Emission over extinction, times opacity."""
    medium = Medium(
        fields={"density": on(device, np.ones((9, 9, 9)))},
        extinction=Curve("density", 1, 0.2 * LINE),
        emission=Curve("density", 1, LINE[:, None] * [0.2, 0.1, 0.4]),
    )
    picture = march(medium, orthographic((9, 9, 9)))
    expected = (1 - np.exp(-1.8)) * np.array([1, 0.5, 2])
    np.testing.assert_allclose(picture.color, np.broadcast_to(expected, picture.color.shape), rtol=1e-5)


@pytest.mark.parametrize("view", VIEWS)
def test_a_white_furnace_stays_white(view, device):
    """With an albedo of 1 in uniform light, nothing can be seen: scattered light and background make 1."""
    volume = noise((20, 16, 13))
    medium = Medium(
        fields={"density": on(device, volume)},
        extinction=Curve("density", 1, 3 * LINE),
        albedo=Curve("density", 1, ONE),
        anisotropy=0.6,
    )
    light = wp.full(volume.shape, wp.vec3(1, 1, 1), dtype=wp.vec3, device=device)
    picture = march(medium, VIEWS[view](volume.shape), ambient=light)
    np.testing.assert_allclose(picture.over(1), 1, atol=2e-6)
    assert picture.alpha.max() > 0.9


@pytest.mark.parametrize("angle", [0, 25])
def test_perspective_becomes_orthographic_with_distance(angle, device):
    """The difference falls as one over the distance."""
    volume = noise((20, 20, 13))
    medium = Medium(fields={"density": on(device, volume)}, extinction=Curve("density", 1, 0.5 * LINE))
    parallel = march(medium, orthographic(volume.shape, angle, 10, size=(40, 26))).alpha
    away = []
    for distance in (100.0, 1000.0, 10000.0):
        view = np.rad2deg(2 * np.arctan(6.5 / distance))
        camera = perspective(volume.shape, angle, 10, distance=distance, field_of_view_deg=view, size=(40, 26))
        away.append(np.abs(march(medium, camera).alpha - parallel).max())
    assert away[1] < 0.2 * away[0]
    assert away[2] < 0.005


@pytest.mark.parametrize("threads", ["1", "2", "5"])
def test_threads_change_no_bit(threads, monkeypatch):
    """Every pixel is on its own."""
    volume = noise((20, 20, 13))
    medium = Medium(fields={"density": on("cpu", volume)}, extinction=Curve("density", 1, LINE))
    camera = perspective(volume.shape, 20, 10, distance=40, field_of_view_deg=30, size=(50, 70))
    before = march(medium, camera)
    monkeypatch.setenv("WARPFLUID_THREADS", threads)
    after = march(medium, camera)
    for name in vars(before):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name))


def test_a_sun_is_scattered_by_the_phase_function(device):
    """Thin fog towards a sun and away from it; its shadow and colour count."""
    g, shape = 0.5, (6, 6, 5)
    medium = Medium(
        fields={"density": on(device, np.ones(shape))},
        extinction=Curve("density", 1, 1e-4 * LINE),
        albedo=Curve("density", 1, np.full((2, 3), [1, 0.5, 0.25])),
        anisotropy=g,
    )
    shadows = np.stack([np.full(shape, 0.5), np.full(shape, 1.0)])
    for direction, cosine in (((0, 0, -1), 1.0), ((0, 0, 1), -1.0), ((1, 0, 0), 0.0)):
        suns = (Sun(np.array(direction), np.array([3.0, 2, 1])), Sun(np.array([0, 1, 0]), np.zeros(3)))
        light = {"shadows": wp.array(shadows, dtype=float, device=device), "lighting": Lighting(suns)}
        picture = march(medium, orthographic(shape, zoom=3), **light)
        phase = (1 - g**2) / (4 * np.pi * (1 + g**2 - 2 * g * cosine) ** 1.5)
        expected = 6e-4 * 0.5 * phase * np.array([3, 1, 0.25])
        np.testing.assert_allclose(picture.color, np.broadcast_to(expected, picture.color.shape), rtol=1e-3)
        np.testing.assert_array_equal(picture.emission, 0)


def test_limits_end_the_rays(device):
    """At a surface between two planes, in front of everything, and nowhere."""
    shape = (6, 12, 5)
    medium = Medium(fields={"density": on(device, np.ones(shape))}, extinction=Curve("density", 1, 0.1 * LINE))
    camera = orthographic(shape, size=(6, 5), zoom=2)
    near = camera.eye[2] - 11  # depth of the nearest plane; the medium begins half a voxel earlier, as a ramp of one
    limits = np.full((5, 6), np.inf)
    limits[0], limits[1] = near + 4.25, 0.0
    picture = march(medium, camera, limits=limits)
    np.testing.assert_allclose(picture.density[0], 4.75, rtol=1e-5)
    np.testing.assert_allclose(picture.alpha[0], 1 - np.exp(-0.475), rtol=1e-5)
    np.testing.assert_array_equal(picture.alpha[1], 0)
    assert np.isinf(picture.depth[1]).all()
    np.testing.assert_allclose(picture.density[2:], 12, rtol=1e-5)


def test_depth_is_where_half_is_reached(device):
    """A wall, a slab seen through thin light, and empty air."""
    volume = np.zeros((9, 40, 5), np.float32)
    volume[:3, 10:13] = 50
    volume[3:6, 5:25] = 0.5
    fields = {"density": on(device, volume)}
    camera = orthographic(volume.shape, size=(40, 5))
    columns = np.round(camera.project([[1, 2, 0], [4, 2, 0], [7, 2, 0]])[:, 0]).astype(int)
    wall, slab, air = march(Medium(fields=fields, extinction=Curve("density", 50, 50 * LINE)), camera).depth[2, columns]
    assert wall == pytest.approx(camera.eye[2] - 13, abs=1)
    assert camera.eye[2] - 25 < slab < camera.eye[2] - 22
    assert np.isinf(air)
    glow = march(Medium(fields=fields, emission=Curve("density", 50, LINE)), camera).depth[2, columns]
    assert glow[0] == pytest.approx(camera.eye[2] - 11, abs=0.6)
    assert glow[1] == pytest.approx(camera.eye[2] - 14.5, abs=0.6)
    assert np.isinf(glow[2])


def test_curves_are_exact_at_their_stops(device):
    """And between them in line, beyond the last as it; a second field multiplies. The ray stays in even light."""
    entries = np.array([[0, 0, 1], [2, 1, 0], [5, 0, 0]])
    curve = Curve("temperature", 2, entries, times="density")
    expected = {0: [0, 0, 1], 0.25: [0.5, 0.25, 0.75], 1: [2, 1, 0], 1.5: [3.5, 0.5, 0], 2: [5, 0, 0], 7: [5, 0, 0]}
    shape = (5, 12, 5)
    camera = orthographic(shape, size=(1, 1), zoom=100)
    camera = replace(camera, eye=camera.eye * [1, 1, 0] + [0, 0, 9.3])
    for value, color in expected.items():
        fields = {"temperature": on(device, np.full(shape, value)), "density": on(device, np.full(shape, 3.0))}
        picture = march(Medium(fields=fields, emission=curve), camera, limits=np.full((1, 1), 6.25))
        np.testing.assert_allclose(picture.color[0, 0], 3 * 6.25 * np.array(color), rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(curve.at(np.array(value)), color, atol=1e-7)


def test_fades_at_the_sides(device):
    """Nothing at the border, everything further in."""
    shape = (21, 21, 21)
    medium = Medium(fields={"density": on(device, np.ones(shape))}, emission=Curve("density", 1, LINE), edge_fade=5.0)
    row = march(medium, orthographic(shape)).color[10, :, 0]
    assert row[0] < 0.05 * row[10]
    assert (np.diff(row[:7]) >= 0).all()
    np.testing.assert_allclose(row, row[::-1], rtol=1e-5)
    assert row[10] == pytest.approx(21 - 5, abs=0.2)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 7, 2), (9, 9, 9)])
def test_an_empty_volume_is_black(shape, device):
    """And clear, at no depth."""
    fields = {"density": wp.zeros(shape, dtype=float, device=device)}
    medium = Medium(fields=fields, extinction=Curve("density", 1, LINE), emission=Curve("density", 1, LINE))
    picture = march(medium, perspective(shape, 30, 20, distance=12, field_of_view_deg=50, size=(7, 5)))
    assert not picture.color.any()
    assert not picture.alpha.any()
    assert np.isinf(picture.depth).all()


def test_eyes_see_the_same_at_the_screen(device):
    """A single voxel there has one place in both pictures."""
    volume = np.zeros((9, 9, 9), np.float32)
    volume[4, 4, 4] = 1
    medium = Medium(fields={"density": on(device, volume)}, emission=Curve("density", 1, LINE))
    camera = perspective(volume.shape, 0, 0, distance=30, field_of_view_deg=20, size=(41, 41))
    left, right = (march(medium, eye).color[..., 0] for eye in stereo_pair(camera, 4, 30))
    at = np.arange(41)
    assert (left.sum(0) * at).sum() / left.sum() == pytest.approx(20, abs=0.05)
    assert (right.sum(0) * at).sum() / right.sum() == pytest.approx(20, abs=0.05)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_refuses_what_is_not_finite(bad, device):
    """In any corner."""
    volume = np.zeros((9, 17, 8), np.float32)
    volume[8, 16, 7] = bad
    medium = Medium(fields={"density": on(device, volume)}, emission=Curve("density", 1, LINE))
    with pytest.raises(ValueError, match="density is not finite"):
        march(medium, orthographic(volume.shape))


def test_refuses_what_does_not_fit(device):
    """Each with its name."""
    density = wp.zeros((4, 4, 4), dtype=float, device=device)
    medium = Medium(fields={"density": density}, emission=Curve("density", 1, LINE))
    camera = orthographic((4, 4, 4))
    shadows = wp.zeros((1, 4, 4, 4), dtype=float, device=device)
    for wrong, match in (
        ({"error": 0}, "error"),
        ({"limits": np.zeros((3, 4))}, "limits"),
        ({"limits": np.full((4, 4), np.nan)}, "limits"),
        ({"shadows": shadows}, "suns"),
        ({"ambient": wp.zeros((3, 4, 4), dtype=wp.vec3, device=device)}, "ambient"),
    ):
        with pytest.raises(ValueError, match=match):
            march(medium, camera, **wrong)
    many = dict.fromkeys("abcdef", density)
    with pytest.raises(ValueError, match="most"):
        march(Medium(fields=many, emission=Curve("a", 1, LINE, times="b"), extinction=Curve("c", 1, LINE, times="d"),
                     albedo=Curve("e", 1, ONE)), camera)  # fmt: skip


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda f: Medium(fields={}), "fields"),
        (lambda f: Medium(fields=f, emission=Curve("flame", 1, LINE)), "flame"),
        (lambda f: Medium(fields=f, extinction=Curve("density", 1, np.ones((2, 3)))), "extinction"),
        (lambda f: Medium(fields=f, albedo=Curve("density", 1, 2 * LINE)), "albedo"),
        (lambda f: Medium(fields=f, anisotropy=1.0), "anisotropy"),
        (lambda f: Medium(fields=f, edge_fade=-1.0), "edge_fade"),
        (lambda f: Curve("density", 0, LINE), "top"),
        (lambda f: Curve("density", 1, -LINE), "negative"),
        (lambda f: Curve("density", 1, np.zeros((2, 2))), "shape"),
        (lambda f: Curve("density", 1, np.array([np.nan])), "finite"),
        (lambda f: Sun(np.zeros(3), np.ones(3)), "direction"),
        (lambda f: Sun(np.ones(3), -np.ones(3)), "color"),
        (lambda f: Lighting(ambient=np.zeros((4, 3))), "ambient"),
        (lambda f: Camera(size=(1, 1), eye=np.zeros(2), right=0, up=0, forward=0, pixel=1, perspective=True), "eye"),
    ],
)
def test_refuses_nonsense(make, match):
    """Where it is made."""
    fields = {"density": wp.zeros((2, 2, 2), dtype=float, device="cpu")}
    with pytest.raises(ValueError, match=match):
        make(fields)

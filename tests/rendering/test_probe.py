"""Light probes against closed forms: nothing is lost, and everything comes from where it should."""

import numpy as np
import pytest

from warpfluid.files.exr import write_exr
from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.harmonics import harmonics, irradiance, radiance, sky, uniform
from warpfluid.rendering.probe import light_from_probe, read_probe, sphere
from warpfluid.rendering.shadows import AROUND

SHAPE = (64, 128)
DIRECTIONS, SOLID = sphere(SHAPE)


def disc(direction, degrees):
    """1 within an angle of a direction."""
    towards = np.asarray(direction) / np.linalg.norm(direction)
    return (DIRECTIONS @ towards > np.cos(np.deg2rad(degrees)))[..., None].astype(float)


def energy(picture):
    return np.einsum("rcd,rc->d", picture, SOLID)


def whole(lighting):
    """What all light of a lighting comes to, over the sphere."""
    return sum((sun.color for sun in lighting.suns), np.sqrt(4 * np.pi) * lighting.ambient[0])


def test_harmonics_are_orthonormal():
    """Their products integrate to 1 and 0."""
    functions = harmonics(DIRECTIONS)
    gram = np.einsum("rci,rcj,rc->ij", functions, functions, SOLID)
    np.testing.assert_allclose(gram, np.eye(9), atol=2e-3)


def test_directions_stand_for_all():
    """The 14 directions integrate harmonics of order 2, and their products, exactly."""
    towards, weights = np.array([d for d, _ in AROUND]), np.array([w for _, w in AROUND])
    functions = harmonics(towards)
    np.testing.assert_allclose(4 * np.pi * weights @ functions, np.sqrt(4 * np.pi) * np.eye(9)[0], atol=1e-12)
    gram = 4 * np.pi * np.einsum("n,ni,nj->ij", weights, functions[:, :4], functions)
    np.testing.assert_allclose(gram, np.eye(4, 9), atol=1e-12)


def test_constant_probe():
    """The closed form: sqrt(4 pi) L, no sun, pi L on every surface."""
    lighting = light_from_probe(np.broadcast_to([1.0, 2.0, 0.5], (*SHAPE, 3)), suns=3)
    assert not lighting.suns
    np.testing.assert_allclose(lighting.ambient, uniform((1, 2, 0.5)), atol=2e-3)
    normals = np.random.default_rng(0).standard_normal((20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(irradiance(lighting.ambient, normals), np.pi * np.array([[1, 2, 0.5]] * 20), rtol=3e-3)


def test_cosine_lobe():
    """(1 + n.d) / 2 is of order 1, so it comes back as it was; a surface that faces it gets 5 pi / 6."""
    towards = np.array([0.6, 0.0, 0.8])
    lobe = np.repeat((0.5 + 0.5 * DIRECTIONS @ towards)[..., None], 3, axis=-1)
    lighting = light_from_probe(lobe, suns=2)
    assert not lighting.suns
    np.testing.assert_allclose(radiance(lighting.ambient, DIRECTIONS), lobe, atol=3e-3)
    assert irradiance(lighting.ambient, towards)[0] == pytest.approx(5 * np.pi / 6, rel=2e-3)


def test_irradiance_of_a_hemisphere():
    """A white sky over black ground: pi above, about a half of it upright; order 2 is within 3 percent."""
    white = np.repeat((DIRECTIONS[..., 1:2] > 0).astype(float), 3, axis=-1)
    ambient = light_from_probe(white, suns=0).ambient
    found = irradiance(ambient, np.array([[0, 1, 0], [1, 0, 0], [0, -1, 0]]))[:, 0]
    np.testing.assert_allclose(found, [np.pi, np.pi / 2, 0], atol=0.03 * np.pi)


def test_sky_is_linear_in_height():
    """As it is told, straight above, below and between."""
    found = radiance(sky((0.2, 0.4, 1.0), (0.1, 0.05, 0.0)), np.array([[0, 1, 0], [0, -1, 0], [1, 0, 0]]))
    np.testing.assert_allclose(found, [[0.2, 0.4, 1], [0.1, 0.05, 0], [0.15, 0.225, 0.5]], atol=1e-12)


def test_suns_are_taken_out():
    """Two lights in a dim sky: where they are, how strong, and all energy is still there."""
    a, b = np.array([0.5, 0.7, 0.5]), np.array([-0.8, 0.2, -0.3])
    picture = 0.1 + disc(a, 4) * [300, 280, 200] + disc(b, 5) * [20, 40, 80]
    lighting = light_from_probe(picture, suns=3)
    assert len(lighting.suns) == 2
    known = ((a, (300, 280, 200), 4), (b, (20, 40, 80), 5))
    for sun, (towards, color, degrees) in zip(lighting.suns, known, strict=True):
        assert np.rad2deg(np.arccos(sun.direction @ towards / np.linalg.norm(towards))) < 1
        solid_angle = (disc(towards, degrees)[..., 0] * SOLID).sum()
        np.testing.assert_allclose(sun.color, np.array(color) * solid_angle, rtol=1e-6)
    np.testing.assert_allclose(whole(lighting), energy(picture), rtol=1e-9)
    np.testing.assert_allclose(lighting.ambient, uniform((0.1, 0.1, 0.1)), atol=1e-3)


@pytest.mark.parametrize("suns", [0, 1, 2, 3])
def test_no_energy_is_lost(suns):
    """Of a ragged probe, whatever is taken out."""
    picture = np.random.default_rng(3).random((*SHAPE, 3)) ** 8 + disc((0, 1, 1), 8) * 30 + disc((1, 0, 0), 3) * 90
    lighting = light_from_probe(picture, suns=suns)
    assert len(lighting.suns) == min(suns, 2)
    np.testing.assert_allclose(whole(lighting), energy(picture), rtol=1e-9)


@pytest.mark.parametrize("shape", [(8, 16), (4, 8)])
def test_tiny_probe(shape):
    """One pixel is wider than a sun, and still is one: where it is, with all of its energy."""
    picture = np.full((*shape, 3), 0.1)
    directions, solid = sphere(shape)
    picture[0, -1] += 50
    lighting = light_from_probe(picture, suns=2)
    np.testing.assert_allclose(whole(lighting), np.einsum("rcd,rc->d", picture, solid), rtol=1e-6)
    for sun in lighting.suns:
        assert np.dot(sun.direction, directions[0, -1]) > np.cos(np.pi / shape[0])


def test_large_probe_is_reduced():
    """By a whole number, with the same suns and sky; one that cannot be is not."""
    for shape in ((768, 1536), (509, 1018)):
        directions, solid = sphere(shape)
        towards = np.array([0.6, 0.64, 0.48])
        picture = np.float32(0.2) + np.where(directions @ towards > np.cos(0.03), 500, 0)[..., None] * [1.0, 0.8, 0.5]
        lighting = light_from_probe(picture, suns=1)
        np.testing.assert_allclose(whole(lighting), np.einsum("rcd,rc->d", picture, solid), rtol=1e-5)
        np.testing.assert_allclose(lighting.suns[0].direction, towards, atol=2e-3)
        np.testing.assert_allclose(lighting.ambient[0], uniform((0.2,) * 3)[0], rtol=1e-3)


@pytest.mark.parametrize("angle", [0, 30, 90, 200])
def test_the_middle_is_behind_the_camera(angle):
    """Turned to a camera's angle, the light in the middle comes from where the camera is; a stop doubles it."""
    picture = 0.01 + disc((0, 0, 1), 5)
    picture = np.repeat(picture, 3, axis=-1)
    assert picture[32, 62:66].all()
    (sun,) = light_from_probe(picture, rotation_deg=angle).suns
    np.testing.assert_allclose(sun.direction, -orthographic((8, 8, 8), angle).forward, atol=0.01)
    (brighter,) = light_from_probe(picture, rotation_deg=angle, exposure=1).suns
    np.testing.assert_allclose(brighter.color, 2 * sun.color)


def test_left_of_the_middle_is_right_of_the_front():
    """As OpenEXR says: z in the middle, x a quarter to the left of it, y above."""
    rows, columns = SHAPE
    np.testing.assert_allclose(DIRECTIONS[rows // 2, columns // 4], [1, 0, 0], atol=0.05)
    np.testing.assert_allclose(DIRECTIONS[0, 0], [0, 1, 0], atol=0.05)


def test_reads_exr(tmp_path):
    """As it was written; grey becomes three colours."""
    picture = np.random.default_rng(0).random((8, 16, 3)).astype(np.float32)
    write_exr(tmp_path / "a.exr", {"RGB": picture})
    np.testing.assert_array_equal(read_probe(tmp_path / "a.exr"), picture)
    write_exr(tmp_path / "b.exr", {"Y": picture[..., 0]})
    assert read_probe(tmp_path / "b.exr").shape == (8, 16, 3)


@pytest.mark.parametrize(("picture", "words"), [(np.ones((8, 8)), "8 x 8"), (-np.ones((8, 16)), "below 0")])
def test_what_is_no_probe(tmp_path, picture, words):
    """One clear error that names the file."""
    write_exr(tmp_path / "a.exr", {"Y": picture.astype(np.float32)})
    with pytest.raises(ValueError, match=words) as found:
        read_probe(tmp_path / "a.exr")
    assert "a.exr" in str(found.value)


def test_other_mistakes(tmp_path):
    """Endings, counts and numbers."""
    with pytest.raises(ValueError, match=r"one of \.exr, \.hdr"):
        read_probe(tmp_path / "a.png")
    with pytest.raises(ValueError, match="0 to 3"):
        light_from_probe(np.ones((8, 16, 3)), suns=4)
    with pytest.raises(ValueError, match="finite"):
        light_from_probe(np.ones((8, 16, 3)), rotation_deg=np.nan)


def test_grey_probe():
    """One channel is as good as three equal ones."""
    grey = np.random.default_rng(0).random((*SHAPE, 1))
    one, three = light_from_probe(grey), light_from_probe(np.repeat(grey, 3, axis=2))
    np.testing.assert_array_equal(one.ambient, three.ambient)


def test_black_probe():
    """No light, no sun."""
    lighting = light_from_probe(np.zeros((8, 16, 3)), suns=3)
    assert not lighting.suns
    assert not lighting.ambient.any()

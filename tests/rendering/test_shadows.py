"""Light within volumes: the white furnace, the sky through a thin cloud, shadows at half resolution."""

import numpy as np
import pytest
import warp as wp
from scipy.ndimage import zoom

from warpfluid.rendering.harmonics import sky, uniform
from warpfluid.rendering.lighting import Lighting, Sun
from warpfluid.rendering.medium import Curve, Medium
from warpfluid.rendering.shadows import cast_shadows, extinction_of, gather_sky, light_volume

SHAPE = (27, 22, 35)


@pytest.fixture
def cloud():
    """Thick in the middle, with holes."""
    x, z, y = np.indices(SHAPE) - np.array([13, 11, 17])[:, None, None, None]
    noise = np.random.default_rng(0).random(SHAPE)
    return (np.exp(-(x**2 + z**2 + y**2) / 60) * noise).astype(np.float32)


def medium_of(field, extinction=2.0, albedo=1.0, device="cpu", **options):
    return Medium(
        fields={"density": wp.array(field, device=device)},
        extinction=Curve("density", 1.0, [0, extinction]),
        albedo=Curve("density", 1.0, [albedo]),
        **options,
    )


@pytest.mark.parametrize("extinction", [0.1, 2.0, 50.0])
def test_white_furnace(cloud, extinction, device):
    """In uniform light, what absorbs nothing is lit as if it were not there, however thick."""
    inner = light_volume(medium_of(cloud, extinction, device=device), Lighting((), uniform((1, 2, 3))))
    assert inner.ambient.shape == SHAPE
    hidden = zoom(inner.light.numpy()[3], 2, order=0)[: SHAPE[0], : SHAPE[1], : SHAPE[2]] < 1e-25
    assert hidden.mean() < 0.05
    shown = inner.ambient.numpy()[~hidden]
    np.testing.assert_allclose(shown, np.broadcast_to([1, 2, 3], shown.shape), rtol=1e-4)


def test_absorbing_cloud_is_darker_within(cloud):
    """The more so the more it absorbs, never darker than without scattering."""
    lit = [light_volume(medium_of(cloud, albedo=a), Lighting((), uniform((1, 1, 1)))).ambient.numpy() for a in (0, 0.5)]
    middle = (13, 11, 17)
    assert lit[0][middle][0] < lit[1][middle][0] < 1
    assert (lit[0] <= lit[1] + 1e-6).all()


def test_sky_from_above_stays_above(cloud):
    """Less of it below the cloud; a voxel in the open gets the mean of the sky."""
    light = gather_sky(extinction_of(medium_of(cloud, 3)), sky((1, 1, 1), (0, 0, 0)), factor=1).numpy()
    assert light[0, 13, 11, 2] < 0.6 * light[0, 13, 11, 33]
    empty = gather_sky(extinction_of(medium_of(0 * cloud)), sky((1, 1, 1), (0, 0, 0)), factor=2).numpy()
    np.testing.assert_allclose(empty[:3], 0.5, rtol=1e-5)
    np.testing.assert_allclose(empty[3], 1, rtol=1e-5)


def test_shadows_of_each_sun(cloud, device):
    """Behind the cloud as the sun sees it; half the resolution shows nearly the same."""
    suns = (Sun((0, 1, 0), (1, 1, 1)), Sun((1, 0.2, 0.3), (1, 1, 1)))
    extinction = extinction_of(medium_of(cloud, device=device))
    fine, coarse = (cast_shadows(extinction, suns, factor=factor).numpy() for factor in (1, 2))
    assert fine.shape == (2, *SHAPE)
    assert fine[0, 13, 11, 1] < 0.1 < 0.9 < fine[0, 13, 11, 33]
    assert fine[1, 2, 9, 13] < 0.2 < 0.9 < fine[1, 25, 14, 20]
    assert np.abs(fine - coarse).mean() < 0.03
    assert np.abs(fine - coarse).max() < 0.4


def test_sun_in_a_cloud_brightens_it(cloud):
    """The sun's light is scattered on; without a sun or an albedo there is none."""
    sun = Sun((0, 1, 0), (4 * np.pi, 0, 0))
    bright = light_volume(medium_of(cloud), Lighting((sun,))).ambient.numpy()
    assert bright[13, 11, 25, 0] > 0.3
    assert bright.max() < 5
    assert not bright[..., 1:].any()
    assert not light_volume(medium_of(cloud, albedo=0), Lighting((sun,))).ambient.numpy().any()


def test_extinction_of_a_medium():
    """Curve, factor and fading sides, as a marcher reads them; none is 0."""
    fields = {"density": np.full((6, 7, 8), 0.5, np.float32), "flame": np.full((6, 7, 8), 3.0, np.float32)}
    fields = {name: wp.array(field) for name, field in fields.items()}
    curve = Curve("density", 1.0, [0, 2.0], times="flame")
    faded = extinction_of(Medium(fields=fields, extinction=curve, edge_fade=1.0)).numpy()
    assert faded[3, 3, 3] == 3
    assert faded[0, 3, 3] == 1.5
    assert not extinction_of(Medium(fields=fields)).numpy().any()


def test_albedo_is_a_share():
    """It cannot be multiplied by a field."""
    medium = Medium(
        fields={"density": wp.zeros((4, 4, 4), dtype=float)}, albedo=Curve("density", 1.0, [1.0], times="density")
    )
    with pytest.raises(ValueError, match="albedo"):
        light_volume(medium, Lighting())


def test_fire_lights_smoke():
    """A small fire in thin smoke is a lamp: intensity / (4 pi r^2) of mean radiance; dense smoke hides it."""
    shape = (48, 48, 48)
    field, flame = np.full(shape, 1.0, np.float32), np.zeros(shape, np.float32)
    flame[22:26, 22:26, 22:26] = 1
    fields = {"density": wp.array(field), "flame": wp.array(flame)}
    emission, albedo = Curve("flame", 1.0, [[0, 0, 0], [5, 2, 0]]), Curve("density", 1.0, [0.0])
    found = []
    for extinction in (1e-5, 0.1):
        medium = Medium(
            fields=fields, emission=emission, albedo=albedo, extinction=Curve("density", 1.0, [0, extinction])
        )
        found.append(light_volume(medium, Lighting()).ambient.numpy()[42, 24, 24])
    distance = 42 - 23.5
    np.testing.assert_allclose(found[0], np.array([5, 2, 0]) * 64 / (4 * np.pi * distance**2), rtol=0.1)
    assert 0.8 * np.exp(-0.1 * distance) < found[1][0] / found[0][0] < np.exp(-0.1 * (distance - 8))

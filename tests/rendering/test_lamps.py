"""The lights that options ask for."""

import numpy as np
import pytest

from warpfluid.files.exr import write_exr
from warpfluid.options import LightOptions
from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.harmonics import radiance
from warpfluid.rendering.lamps import Lamps


def test_a_key_light_of_one_makes_a_white_surface_white():
    (sun,) = Lamps(LightOptions(key_color="1,0.5,0.25", key_strength=1, ambient=0)).at(1).suns
    np.testing.assert_allclose(np.array(sun.color) / np.pi, (1, 0.5, 0.25))


def test_the_mean_of_the_sky_is_the_ambient_light():
    light = Lamps(LightOptions(ambient=0.4, ambient_color="1,0.5,0.25")).at(1)
    around = np.concatenate([np.eye(3), -np.eye(3)])
    np.testing.assert_allclose(radiance(light.ambient, around).mean(axis=0), 0.4 * np.array([1, 0.5, 0.25]))
    above, below = radiance(light.ambient, np.array([[0.0, 1, 0], [0, -1, 0]]))
    assert (above > below).all()


def test_fire_on_the_ground_is_the_light_itself():
    """Unless a light is chosen, there is no ground, or the look is one that scatters."""

    def at(look="fire", **options):
        light = Lamps(LightOptions(**{"ground": True, "ambient_color": "1,1,1", **options})).usual_for(look).at(1)
        around = np.concatenate([np.eye(3), -np.eye(3)])
        return len(light.suns), round(float(radiance(light.ambient, around).mean()), 4)

    for night in (at(), at("blackbody")):
        assert night == (0, 0.03)
    for day in (at("smoke"), at("explosion"), at(ground=False), at(key_strength=2)):
        assert day == (1, 0.12)
    assert at(ambient=0.4) == (0, 0.4)


def test_lights_may_be_keyed():
    lamps = Lamps(LightOptions(key_light="1:1,0,0;3:0,1,0", key_strength="1:0;3:2"))
    assert not lamps.at(1).suns
    (sun,) = lamps.at(2).suns
    np.testing.assert_allclose(sun.direction, np.array([1, 1, 0]) / np.sqrt(2))
    np.testing.assert_allclose(lamps.at(9).suns[0].color, 2 * np.pi * np.array([1, 0.95, 0.88]))


@pytest.mark.parametrize("strength", [0.5, 2.0])
def test_a_probe_counts_instead(tmp_path, strength):
    write_exr(tmp_path / "sky.exr", {"RGB": np.full((32, 64, 3), 0.3, np.float32)})
    lamps = Lamps(LightOptions(probe=str(tmp_path / "sky.exr"), probe_strength=strength))
    light = lamps.at(1)
    assert not light.suns
    np.testing.assert_allclose(radiance(light.ambient, np.eye(3)), 0.3 * strength, rtol=5e-3)
    assert len(Lamps(LightOptions(probe=str(tmp_path / "sky.exr"), key_strength=1)).at(1).suns) == 1


def test_a_sky_is_shown_if_asked_for(tmp_path):
    """As strong as its light; never without a probe."""
    write_exr(tmp_path / "sky.exr", {"RGB": np.full((32, 64, 3), 0.3, np.float32)})
    camera, probe = orthographic((4, 4, 6)), {"probe": str(tmp_path / "sky.exr"), "probe_strength": "1:1;3:3"}
    sky = Lamps(LightOptions(sky=True, **probe)).sky(camera, 2)
    np.testing.assert_allclose(sky, np.full((6, 4, 3), 0.6), rtol=1e-6)
    assert Lamps(LightOptions(**probe)).sky(camera, 2) is None
    with pytest.raises(ValueError, match="--probe"):
        LightOptions(sky=True)

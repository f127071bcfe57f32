"""Frames put into light, and what a screen shows of them."""

from dataclasses import replace

import numpy as np
import pytest

from warpfluid.files.exr import write_exr
from warpfluid.options import LightOptions, RenderOptions
from warpfluid.rendering.camera import orthographic
from warpfluid.rendering.display import decode_srgb
from warpfluid.rendering.lamps import Lamps
from warpfluid.rendering.look_files import make_look
from warpfluid.rendering.output import side_by_side
from warpfluid.rendering.picture import Picture
from warpfluid.rendering.ramps import apply_ramp
from warpfluid.rendering.studio import make_studio, stand_ins

SHAPE = (10, 10, 12)
DARK = LightOptions(key_strength=0, ambient=0)
OUTLINE = np.array([[2, 2, 6], [8, 2, 6], [5, 9, 6]], float), np.array([[0, 1, 2]])


def studio(light=DARK, **choices):
    return make_studio(RenderOptions(**{"look": "smoke", **choices}), Lamps(light), "smoke", "cpu")


def fog(amount=20.0):
    density = np.zeros(SHAPE, np.float32)
    density[2:-2, 2:-2, 2:-2] = amount
    return {"density": density}


def shoot(place, fields, number=1, outlines=()):
    return place.shoot(place.light(fields, number), orthographic(SHAPE), number, outlines)


def picture(color, alpha):
    color = np.asarray(color, np.float32).reshape(1, 1, 3)
    alpha = np.full((1, 1), alpha, np.float32)
    return Picture(color, alpha, alpha, 100 * alpha, color)


def test_smoke_without_light_is_black_and_hides():
    seen = shoot(studio(), fog())
    assert seen.color.max() == 0
    assert seen.alpha[6, 5] > 0.9
    assert seen.alpha[0, 0] == 0


def test_white_smoke_in_even_light_is_as_bright_as_the_light(tmp_path):
    """The furnace, through the whole studio."""
    write_exr(tmp_path / "even.exr", {"RGB": np.full((32, 64, 3), 0.5, np.float32)})
    white = make_look({"color": {"stops": [[0, 1]]}, "opacity": {"stops": [[0, 0], [1, 3]]}}, "white")
    seen = shoot(replace(studio(LightOptions(probe=str(tmp_path / "even.exr"))), look=white), fog())
    assert seen.alpha.max() > 0.9
    np.testing.assert_allclose(seen.over(np.full(3, 0.5)), 0.5, atol=0.01)


def test_thickness_and_glow_and_bias_bend_the_look():
    thin, usual = (shoot(studio(thickness=k), fog(2.0)).alpha.max() for k in (0.25, 1.0))
    assert -np.log(1 - usual) == pytest.approx(-4 * np.log(1 - thin), rel=0.02)
    dim, bright = (shoot(studio(look="fire", glow=k), fog()).color.max() for k in (1.0, 3.0))
    assert bright == pytest.approx(3 * dim, rel=1e-3)
    assert shoot(studio(look="fire", bias=0.5), fog()).color.max() > 1.2 * dim


def test_the_sky_is_light_behind_the_picture(tmp_path):
    """It is exposed with the rest, shines through, and is no part of the colour."""
    write_exr(tmp_path / "even.exr", {"RGB": np.full((32, 64, 3), 0.5, np.float32)})
    place = studio(LightOptions(probe=str(tmp_path / "even.exr"), sky=True), exposure=-1.0, rolloff=1.0)
    seen = shoot(place, fog())
    assert seen.color[0, 0].max() == 0
    shown = decode_srgb(place.screen(seen, 1))
    np.testing.assert_allclose(shown[0, 0], 0.25, rtol=1e-4)
    np.testing.assert_allclose(shown, 0.5 * seen.over(np.full(3, 0.5)), atol=1e-4)
    assert side_by_side([seen, seen]).sky.shape == (12, 20, 3)


def test_emission_has_no_lamps():
    place = studio(LightOptions(key_strength=100), mode="emission")
    assert shoot(place, fog()).color.max() == 0


def test_the_sum_ignores_looks_lamps_and_things():
    place = studio(mode="sum", look="jet")
    seen = shoot(place, fog(), outlines=[(*OUTLINE, "body")])
    assert seen.density.max() == pytest.approx(20 * 6)
    shown = place.screen(seen, 1)
    np.testing.assert_allclose(shown * 255, apply_ramp(seen.density, "jet"), atol=1e-3)
    np.testing.assert_allclose(seen.color[..., 0], seen.density / 255)


def test_bodies_and_obstacles_have_their_colours():
    place = studio(LightOptions(key_strength=0, ambient=1, ambient_color="1,1,1", body_color="1,0,0"))
    red, grey = (shoot(place, fog(0.0), outlines=[(*OUTLINE, kind)]).color[6, 5] for kind in ("body", "obstacle"))
    assert red[0] > 0.3
    assert red[1:].max() < 0.01
    assert grey.min() > 0.1


def test_backdrop_is_exact_where_nothing_is():
    place = studio(backdrop="0.25,0.5,0.75", exposure=3.0)
    np.testing.assert_allclose(place.screen(picture([0, 0, 0], 0), 1)[0, 0], (0.25, 0.5, 0.75), atol=1e-6)
    half = decode_srgb(place.screen(picture([0, 0, 0], 0.5), 1)[0, 0])
    np.testing.assert_allclose(half, decode_srgb(np.array([0.25, 0.5, 0.75])) / 2, atol=1e-6)
    assert place.screen(picture([0, 0, 0], 1), 1).max() == 0


def test_exposure_is_keyed():
    place = studio(exposure="1:0;3:2", rolloff=1.0)
    levels = [decode_srgb(place.screen(picture([0.1, 0.1, 0.1], 1), number))[0, 0, 0] for number in (1, 2, 3)]
    np.testing.assert_allclose(levels, [0.1, 0.2, 0.4], rtol=1e-5)


def test_light_is_found_once_for_a_frame():
    place, fields = studio(LightOptions(key_strength="1:1;2:1;3:2")), fog()
    first = place.light(fields, 1)
    assert place.light(fields, 2) is first
    assert place.light(fields, 3) is not first
    assert place.light(fog(), 3) is not first


def test_names_are_what_the_look_and_the_shutter_need():
    assert studio().names == {"density"}
    assert studio(look="explosion").names == {"density", "temperature", "flame"}
    assert studio(motion_blur=0.5).names == {"density", "velocity"}
    speed = make_look({"emission": {"input": "speed", "stops": [[0, 0], [1, 1]]}}, "speed")
    assert replace(studio(), look=speed).names == {"density", "velocity"}


def test_speed_is_made_of_velocity():
    speed = make_look({"emission": {"input": {"speed": 10}, "stops": [[0, 0], [1, 12]]}}, "speed")
    velocity = np.zeros((*SHAPE, 3), np.float32)
    velocity[3:6, 3:6, 3:6] = (0, 3.6, 4.8)  # 6 voxels a second: 5 units, of a box 12 high
    seen = shoot(replace(studio(), look=speed), fog() | {"velocity": velocity})
    along = 3 * 10 / 12  # units of three voxels
    assert seen.color.max() == pytest.approx(6 * along, rel=0.01)


def test_stand_ins_are_named():
    look = studio(look="explosion").look
    (line,) = stand_ins(look, ["density", "velocity"])
    assert line == "the emission of explosion wants temperature, which is not there: density stands in for it"
    assert not stand_ins(look, ["density", "temperature"])


def test_the_mode_sum_knows_ramps_only():
    with pytest.raises(ValueError, match=r"look is 'mine\.json', but the mode sum knows fire"):
        studio(mode="sum", look="mine.json")

"""Looks: ramps, what they take, and files that are no looks."""

import json
from typing import get_args, get_type_hints

import numpy as np
import pytest
import warp as wp

from warpfluid.options import OutputOptions, RenderOptions
from warpfluid.rendering.blackbody import blackbody_color
from warpfluid.rendering.look_files import look_names, make_look, read_look
from warpfluid.rendering.looks import FIELDS, amount_of_one
from warpfluid.rendering.ramps import RAMPS

NAMES = ("blackbody", "explosion", "fire", "gray", "jet", "smoke", "water")
STOPS = [[0, [0, 0, 0]], [0.125, [0.2, 0.5, 3]], [0.7, [7, 0.1, 2]], [1, [1.5, 2, 9]]]


def look(**ramps):
    return make_look(ramps, "mine")


def test_the_promised_looks_are_there():
    assert tuple(look_names()) == NAMES


def test_help_and_turntable_know_all_looks():
    told = get_args(get_type_hints(RenderOptions, include_extras=True)["look"])[1]
    assert {name for name in told.replace(",", " ").split() if name in NAMES} == {*NAMES}
    assert set(RAMPS) == {*NAMES} == set(get_args(get_type_hints(OutputOptions)["look"]))


@pytest.mark.parametrize("name", NAMES)
def test_package_looks_are_explained_and_make_media(name):
    found = read_look(name)
    assert found.about
    fields = {field: wp.zeros((2, 3, 4), dtype=float, device="cpu") for field in FIELDS}
    medium = found.medium(fields)
    assert medium.emission or medium.albedo
    for curve in (medium.emission, medium.extinction):
        assert curve is None or curve.values[0].max() == 0 or curve.times  # nothing where nothing is


def test_ramps_are_exact_at_their_stops():
    ramp = look(emission={"input": {"temperature": 2}, "stops": STOPS, "scale": 3}).ramps["emission"]
    for position, color in STOPS:
        np.testing.assert_allclose(ramp.at([2 * position], "temperature")[0], 3 * np.array(color), rtol=1e-12)


def test_curves_are_exact_at_the_stops():
    """Of a medium, in its own units: a voxel of a box 40 high is a quarter of a unit long."""
    curve = look(emission={"stops": STOPS}).ramps["emission"].curve("density", 40)
    assert curve.top == pytest.approx(4 * 255 / 40)
    for position, color in STOPS:
        np.testing.assert_allclose(curve.at(np.array([curve.top * position]))[0], 0.25 * np.array(color), rtol=1e-6)


def test_values_are_constant_beyond_the_ends():
    ramp = look(emission={"stops": [[0.25, 1], [0.75, 3]]}).ramps["emission"]
    assert ramp.at([0, 0.25, 0.5, 0.75, 1, 9], "density")[:, 0].tolist() == [1, 1, 2, 3, 3, 3]


@pytest.mark.parametrize("bias", [-0.6, 0.0, 0.4])
def test_bias_moves_the_middle_and_keeps_the_ends(bias):
    ramp = look(opacity={"stops": [[0, 0], [1, 1]], "bias": bias}).ramps["opacity"]
    np.testing.assert_allclose(ramp.at([0, 0.5, 1], "density")[:, 0], [0, 0.5 + bias / 2, 1], atol=1e-12)
    biased = look(opacity={"stops": [[0, 0], [1, 1]]}).with_bias(bias).ramps["opacity"]
    np.testing.assert_array_equal(biased.at([0.3], "density"), ramp.at([0.3], "density"))


def test_values_above_one_are_kept():
    curve = look(emission={"stops": [[0, 0], [1, 1e4]]}).ramps["emission"].curve("density", 10)
    assert curve.values.max() == 1e4


def test_blackbody_colours_the_brightness():
    ramp = look(emission={"stops": [[0, 0], [1, 5]], "blackbody": [1000, 3000]}).ramps["emission"]
    np.testing.assert_allclose(ramp.at([0.5], "density"), 2.5 * blackbody_color([2000]))


def test_optical_depth_is_that_of_the_ray_sum_at_any_resolution():
    """Two units of opacity at full density: a white ray, a quarter of the height of it, has 2 x 2.5."""
    for height in (16, 100):
        curve = look(opacity={"stops": [[0, 0], [1, 1]], "scale": 2}).ramps["opacity"].curve("density", height)
        ray = np.full(height // 4, 4 * 255 / height)
        assert curve.at(ray)[:, 0].sum() == pytest.approx(5, rel=1e-6)


def test_times_density_is_in_full_densities():
    ramp = look(emission={"input": "temperature", "stops": [[0, 0], [1, 6]], "times": "density"}).ramps["emission"]
    curve = ramp.curve("temperature", 30)
    assert curve.times == "density"
    full = amount_of_one("density", 30)
    np.testing.assert_allclose(curve.at(np.ones(1))[0] * full, 6 * 10 / 30, rtol=1e-6)


def test_the_first_input_that_is_there_is_taken():
    ramps = look(emission={"input": {"flame": 1, "temperature": 2}, "stops": [[0, 0], [1, 1]]})
    assert ramps.fields(["density", "temperature", "flame"]) == {"emission": "flame"}
    assert ramps.fields(["density", "temperature"]) == {"emission": "temperature"}
    assert ramps.fields(["density"]) == {"emission": "density"}


def test_units_of_fields():
    assert amount_of_one("density", 255) == 4
    assert amount_of_one("speed", 50) == 5
    assert amount_of_one("flame", 50) == amount_of_one("temperature", 7) == 1


def test_scaling():
    found = look(opacity={"stops": [[0, 0], [1, 1]], "scale": 3}).scaled(opacity=2, emission=5)
    assert found.ramps["opacity"].at([1], "density")[0, 0] == 6


BAD = {
    "no ramp": ({"about": "x"}, "at least one of color, emission, opacity"),
    "no object": ([1], "is no look"),
    "unknown": ({"opacity": {"stops": [[0, 0]]}, "glow": 1}, "'glow' is unknown"),
    "unknown in ramp": ({"opacity": {"stops": [[0, 0]], "ramp": 1}}, "opacity: 'ramp' is unknown"),
    "no stops": ({"opacity": {"input": "density"}}, "input and stops"),
    "input": ({"opacity": {"input": "pressure", "stops": [[0, 0]]}}, "input is 'pressure'"),
    "amount": ({"opacity": {"input": {"density": 0}, "stops": [[0, 0]]}}, "density ends at 0"),
    "falling": ({"opacity": {"stops": [[0.5, 0], [0.2, 1]]}}, "must rise, they are 0.5, 0.2"),
    "outside": ({"opacity": {"stops": [[0, 0], [1.5, 1]]}}, "from 0 to 1"),
    "negative": ({"emission": {"stops": [[0, -1]]}}, "of 0 or more"),
    "infinite": ({"emission": {"stops": [[0, float("inf")]]}}, "of 0 or more"),
    "text": ({"emission": {"stops": [[0, "red"]]}}, "a number or"),
    "two colours": ({"emission": {"stops": [[0, [1, 2]]]}}, "a number or"),
    "albedo": ({"color": {"stops": [[0, 1.5]]}}, "here 0 to 1"),
    "colour scale": ({"color": {"stops": [[0, 1]], "scale": 2}}, "expected 0 to 1"),
    "coloured opacity": ({"opacity": {"stops": [[0, [1, 0, 0]]]}}, "hides all colours alike"),
    "bias": ({"opacity": {"stops": [[0, 0]], "bias": 1}}, "bias is 1"),
    "kelvin": ({"emission": {"stops": [[0, 0]], "blackbody": [3000]}}, "two temperatures"),
    "kelvin of colour": ({"color": {"stops": [[0, 0]], "blackbody": [1000, 2000]}}, "for emission only"),
    "times": ({"emission": {"stops": [[0, 0]], "times": "speed"}}, "expected density"),
    "anisotropy": ({"opacity": {"stops": [[0, 0]]}, "anisotropy": 1}, "-0.95 to 0.95"),
    "about": ({"opacity": {"stops": [[0, 0]]}, "about": 1}, "expected text"),
}


@pytest.mark.parametrize(("document", "message"), BAD.values(), ids=BAD)
def test_bad_looks_are_refused(document, message, tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"mine\.json") as caught:
        read_look(str(path))
    assert message in str(caught.value)


def test_everything_wrong_is_told_at_once():
    with pytest.raises(ValueError, match="anisotropy") as caught:
        make_look({"opacity": {"stops": [], "bias": 2}, "anisotropy": "much"}, "mine")
    assert len(str(caught.value).splitlines()) == 3


def test_unknown_names_list_the_known_ones():
    with pytest.raises(ValueError, match="blackbody, explosion, fire"):
        read_look("fier")


def test_files_that_are_no_json_or_missing(tmp_path):
    (tmp_path / "a.json").write_text("{")
    with pytest.raises(ValueError, match=r"a\.json is no JSON"):
        read_look(str(tmp_path / "a.json"))
    with pytest.raises(OSError, match=r"none\.json"):
        read_look(str(tmp_path / "none.json"))

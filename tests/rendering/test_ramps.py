"""Colour ramps: exact at their stops, never darker for brighter, safe for any input."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warpfluid.rendering.ramps import RAMPS, apply_ramp

LUMA = np.array([0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("name", RAMPS)
def test_stops_are_exact(name):
    """A stop's grey level gives its colour, whatever white is."""
    levels = np.array(list(RAMPS[name]))
    wanted = np.array(list(RAMPS[name].values()))
    np.testing.assert_array_equal(apply_ramp(levels, name), wanted)
    np.testing.assert_array_equal(apply_ramp(levels / 100, name, white=2.55), wanted)


@pytest.mark.parametrize("name", sorted(set(RAMPS) - {"jet"}))
def test_brighter_is_lighter(name):
    """Luminance never falls along a ramp that is not jet, and covers nearly black to nearly white."""
    luma = apply_ramp(np.linspace(0, 255, 2000), name) @ LUMA
    assert (np.diff(luma) >= 0).all()
    assert luma[0] == 0
    assert luma[-1] > 240


@pytest.mark.parametrize("name", RAMPS)
def test_no_step_is_seen(name):
    """Neighbouring grey levels differ by a few steps of a channel at most."""
    colours = apply_ramp(np.arange(256), name).astype(int)
    assert np.abs(np.diff(colours, axis=0)).max() <= 5


def test_jet_is_the_classic_map():
    """Jet is three clipped tents, a quarter of the range apart."""
    x = np.linspace(0, 1, 500)
    tents = [np.clip(1.5 - np.abs(4 * x - top), 0, 1) for top in (3, 2, 1)]
    assert np.abs(apply_ramp(255 * x, "jet") - 255 * np.stack(tents, axis=-1)).max() < 1.5


@given(st.lists(st.floats(width=32), min_size=1, max_size=8), st.sampled_from(sorted(RAMPS)))
def test_any_value_has_a_colour(values, name):
    """What is negative, too bright or not a number takes an end of the ramp, and shapes are kept."""
    images = np.array(values, np.float32).reshape(1, -1)
    colours = apply_ramp(images, name)
    assert colours.shape == (*images.shape, 3)
    assert colours.dtype == np.uint8
    ends = list(RAMPS[name].values())
    np.testing.assert_array_equal(colours[images <= 0], np.broadcast_to(ends[0], colours[images <= 0].shape))
    above = (images >= 255) & np.isfinite(images)
    np.testing.assert_array_equal(colours[above], np.broadcast_to(ends[-1], colours[above].shape))


def test_unknown_ramps_and_whites_are_refused():
    """The message lists the ramps there are."""
    with pytest.raises(ValueError, match="'plasma'; choose one of fire, smoke, explosion, blackbody, water, jet, gray"):
        apply_ramp(np.zeros(3), "plasma")
    with pytest.raises(ValueError, match="white is 0"):
        apply_ramp(np.zeros(3), "gray", white=0)

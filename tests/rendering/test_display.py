"""From light to the screen."""

import numpy as np
import pytest

from warpfluid.rendering.display import decode_srgb, develop, encode_srgb, quantize


def test_srgb_at_known_values():
    light = np.array([0, 0.0031308, 0.18, 0.5, 1])
    np.testing.assert_allclose(encode_srgb(light), [0, 0.04045, 0.46136, 0.73536, 1], atol=1e-4)


def test_srgb_round_trip():
    values = np.linspace(0, 1, 256)
    np.testing.assert_allclose(encode_srgb(decode_srgb(values)), values, atol=1e-6)


@pytest.mark.parametrize("rolloff", [0.2, 0.6, 1.0])
def test_light_below_the_rolloff_is_kept(rolloff):
    light = np.linspace(0, rolloff, 20)[:, None].repeat(3, axis=1)
    np.testing.assert_allclose(decode_srgb(develop(light, rolloff=rolloff)), light, atol=2e-6)


def test_rolloff_is_smooth_and_rises_to_white():
    light = np.linspace(0, 8, 4001)[:, None].repeat(3, axis=1)
    shown = decode_srgb(develop(light, rolloff=0.5))[:, 0]
    slope = np.diff(shown) / np.diff(light[:, 0])
    assert (slope > -1e-5).all()
    assert np.abs(np.diff(slope[light[1:, 0] < 0.9])).max() < 0.02
    assert 0.999 < shown[-1] <= 1


def test_clipping_is_a_rolloff_of_one():
    light = np.array([[0.25, 1.0, 7.0]])
    np.testing.assert_allclose(decode_srgb(develop(light, rolloff=1.0)), [[0.25, 1, 1]], atol=1e-6)


def test_very_bright_colour_turns_pale():
    dim, bright = (develop(np.array([[k, 0.3 * k, 0.0]]))[0] for k in (0.5, 12))
    assert dim[2] == 0
    assert bright[2] > 0.5


def test_exposure_counts_in_stops():
    light = np.array([[0.1, 0.05, 0.02]])
    np.testing.assert_allclose(develop(light, exposure=2.0), develop(4 * light), atol=1e-6)


def test_quantize():
    assert quantize(np.array([0, 0.5, 1, 2])).tolist() == [0, 128, 255, 255]
    assert quantize(np.array([0, 1]), 16).tolist() == [0, 65535]
    assert quantize(np.array([0]), 16).dtype == np.uint16

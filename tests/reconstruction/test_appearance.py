"""The M-step: views take on the inputs' statistics, neighbours are found, also across the wrap."""

import numpy as np
import pytest

from warpfluid.projector import Projector
from warpfluid.reconstruction.appearance import AppearanceTransfer
from warpfluid.reconstruction.pyramid import SteerablePyramid

ANGLES = (0.0, 90.0)
FAN = tuple(float(angle) for angle in range(0, 180, 15))


@pytest.fixture(scope="module")
def pictures(fire):
    """Views of the fire by angle."""
    angles = [0, 30, 60, 90, 120, 150]
    return dict(zip(angles, Projector(angles, fire.shape, device="cpu").project(fire), strict=True))


@pytest.fixture(scope="module")
def inputs(pictures):
    """Front and side."""
    return np.stack([pictures[0], pictures[90]])


def transferred(inputs, angles, fan, rendered, **options):
    mask = np.ones(rendered.shape, bool)
    return AppearanceTransfer(inputs, angles, fan, **options).transfer(rendered, mask)


@pytest.mark.parametrize("interpolation", ["density", "quantile", "hybrid", "nearest"])
def test_an_input_is_transferred_to_itself(inputs, interpolation):
    """A view that looks right already is left alone."""
    found = transferred(inputs, ANGLES, ANGLES, inputs, interpolation=interpolation)
    np.testing.assert_allclose(found, inputs, atol=0.25)


def test_a_blurred_view_becomes_as_sharp_as_the_inputs(inputs, pictures):
    """The grey values are the inputs', and the spread of the fine bands nears theirs."""
    blurred = np.mean([np.roll(pictures[0], shift, axis=0) for shift in range(-3, 4)], axis=0)[None]
    found = transferred(inputs, ANGLES, (0.0,), blurred)
    np.testing.assert_allclose(np.sort(found, axis=None), np.sort(inputs[0], axis=None), atol=6)
    pyramid = SteerablePyramid(inputs.shape[1:], 2)

    def spreads(image):
        return np.array([pyramid.build(image)[0, band].std() for band in range(4)])

    wanted = spreads(inputs[0])
    assert np.abs(spreads(found[0]) - wanted).sum() < 0.5 * np.abs(spreads(blurred[0]) - wanted).sum()


def test_the_order_of_the_inputs_does_not_matter(inputs, pictures):
    """Unsorted angles are sorted."""
    images, angles = np.stack([pictures[120], pictures[0], pictures[60]]), (120.0, 0.0, 60.0)
    rendered = np.repeat(inputs[:1], len(FAN), axis=0)
    expected = transferred(images[[1, 2, 0]], (0.0, 60.0, 120.0), FAN, rendered)
    np.testing.assert_array_equal(transferred(images, angles, FAN, rendered), expected)


def test_only_the_two_neighbours_count(pictures):
    """Between 0 and 60 degrees it is all the same what the view at 120 shows."""
    rendered = pictures[30][None]
    images = np.stack([pictures[0], pictures[60], pictures[120]])
    found = transferred(images, (0.0, 60.0, 120.0), (30.0,), rendered)
    np.testing.assert_array_equal(transferred(images[:2], (0.0, 60.0), (30.0,), rendered), found)


@pytest.mark.parametrize("angle", [120.0, 150.0, 170.0])
def test_beyond_the_last_input_comes_the_first_one_mirrored(pictures, angle):
    """The same as if everything had been turned so that no half turn lies between."""
    rendered = pictures[150][None]
    found = transferred(np.stack([pictures[0], pictures[90]]), ANGLES, (angle,), rendered)
    turned = np.stack([pictures[90], pictures[0][::-1]])
    np.testing.assert_array_equal(transferred(turned, ANGLES, (angle - 90,), rendered), found)


@pytest.mark.parametrize("angle", [0.0, 10.0])
def test_before_the_first_input_comes_the_last_one_mirrored(pictures, angle):
    """The fan begins before the first view."""
    rendered = pictures[0][None]
    found = transferred(np.stack([pictures[30], pictures[120]]), (30.0, 120.0), (angle,), rendered)
    turned = np.stack([pictures[120][::-1], pictures[30]])
    expected = transferred(turned, (0.0, 90.0), (angle + 60,), rendered)
    np.testing.assert_allclose(found, expected, atol=1e-3)


def test_one_input_stands_on_both_sides(pictures):
    """At its own angle the view is kept; a quarter turn away it mixes with its mirror image."""
    front = pictures[0][None]
    np.testing.assert_allclose(transferred(front, (20.0,), (20.0,), front), front, atol=0.25)
    explicit = np.stack([pictures[0], pictures[0][::-1]])
    expected = transferred(explicit, (20.0, 179.0), (99.5,), front)
    found = transferred(front, (20.0,), (110.0,), front)
    np.testing.assert_allclose(found, expected, atol=1e-3)


def test_first_takes_the_first_input_alone(inputs, pictures):
    """For every angle, as in Fig. 7."""
    rendered = np.repeat(pictures[60][None], 3, axis=0)
    found = transferred(inputs[::-1], ANGLES[::-1], (0.0, 45.0, 89.0), rendered, interpolation="first")
    alone = transferred(inputs[1:], (45.0,), (45.0,), pictures[60][None])
    np.testing.assert_allclose(found[1:], np.repeat(alone, 2, axis=0), atol=1e-3)


def test_outside_the_mask_it_is_black(inputs):
    """And inside the values are the inputs', although fewer pixels share them."""
    mask = np.zeros(inputs.shape, bool)
    mask[:, 12:36] = True
    found = AppearanceTransfer(inputs, ANGLES, ANGLES).transfer(inputs, mask)
    assert not found[~mask].any()
    assert found.min() >= 0
    assert found.max() <= inputs.max() * 1.001


def test_a_thin_view_does_not_light_its_background(inputs):
    """What comes out of the bands at or below black stays black, however much the inputs show."""
    thin = np.zeros_like(inputs)
    thin[:, 18:30] = inputs[:, 12:36:2]
    found = transferred(inputs, ANGLES, ANGLES, thin)
    assert (found == 0).mean() > 0.4
    assert found[:, :8].max() < 0.05 * found.max()


def test_a_black_view_stays_finite(inputs):
    """A collapsed volume is no reason to divide by zero."""
    found = transferred(inputs, ANGLES, ANGLES, np.zeros_like(inputs))
    assert np.isfinite(found).all()


def test_any_number_of_threads_and_views_gives_the_same_bits(inputs, monkeypatch):
    """A view does not depend on those beside it."""
    rng = np.random.default_rng(0)
    rendered = np.stack([np.roll(inputs[i % 2], rng.integers(9), axis=0) for i in range(len(FAN))])
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        results.append(transferred(inputs, ANGLES, FAN, rendered))
    np.testing.assert_array_equal(*results)
    for i in (0, 5, 11):
        np.testing.assert_array_equal(
            transferred(inputs, ANGLES, FAN[i : i + 1], rendered[i : i + 1])[0], results[0][i]
        )

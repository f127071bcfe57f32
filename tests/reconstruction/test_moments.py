"""Projections onto moments: they reach them, and change nothing that has them."""

import numpy as np
import pytest
from scipy import stats
from scipy.ndimage import gaussian_filter

from warpfluid.reconstruction import moments


def noise(seed, grains=(1, 2, 1.5)):
    """Images of unit variance and mean 0, as smooth as the grains say."""
    rng = np.random.default_rng(seed)
    images = np.stack([gaussian_filter(rng.standard_normal((40, 51)), grain, mode="wrap") for grain in grains])
    return (images - images.mean(axis=(1, 2), keepdims=True)) / images.std(axis=(1, 2), keepdims=True)


def test_moments_are_those_of_scipy():
    """Mean, variance, skewness and kurtosis; flat images have those of a flat line."""
    images = np.exp(noise(0)) + 3
    flat = images.reshape(3, -1)
    wanted = [flat.mean(axis=1), flat.var(axis=1), stats.skew(flat, axis=1), stats.kurtosis(flat, axis=1, fisher=False)]
    np.testing.assert_allclose(moments.standard_moments(images), np.transpose(wanted), rtol=1e-9)
    np.testing.assert_allclose(moments.standard_moments(np.full((1, 4, 4), 2.0)), [[2, 0, 0, 3]])


def test_autocorrelations_are_mean_products_of_shifted_images():
    """Circular ones."""
    image = noise(1)[0]
    found = moments.autocorrelation(image, 2)
    for a in range(-2, 3):
        for b in range(-2, 3):
            assert found[a + 2, b + 2] == pytest.approx((image * np.roll(image, (a, b), (0, 1))).mean(), abs=1e-12)


def test_an_autocorrelation_is_reached():
    """In a few rounds, the variance at once; phases stay, and the own one changes nothing."""
    images, wanted = noise(0), moments.autocorrelation(noise(1, (1.6, 1, 2.5)), 2)
    made = images
    for _ in range(6):
        made = moments.set_autocorrelation(made, wanted)
        np.testing.assert_allclose(made.var(axis=(1, 2)), wanted[:, 2, 2], rtol=1e-9)
    assert np.abs(moments.autocorrelation(made, 2) - wanted).max() < 0.005
    turned = np.fft.fft2(made) * np.conj(np.fft.fft2(images))
    assert np.abs(turned.imag).max() < 1e-9 * np.abs(turned).max()
    assert turned.real.min() > -1e-9 * np.abs(turned).max()
    np.testing.assert_allclose(moments.set_autocorrelation(made, moments.autocorrelation(made, 3)), made, atol=1e-9)


@pytest.mark.parametrize(("change", "column"), [(moments.set_skewness, 2), (moments.set_kurtosis, 3)])
def test_skewness_and_kurtosis_are_reached(change, column):
    """Mean and variance stay, and the own value changes nothing."""
    images, wanted = noise(0), np.array([[-0.8, 1.2, 2], [1.9, 4, 7]])[column - 2]
    made = change(images, wanted)
    found = moments.standard_moments(made)
    np.testing.assert_allclose(found[:, column], wanted, rtol=1e-3)
    np.testing.assert_allclose(found[:, :2], moments.standard_moments(images)[:, :2], atol=1e-9)
    own = moments.standard_moments(images)[:, column]
    np.testing.assert_allclose(change(images, own), images, atol=1e-4)


def test_a_moment_out_of_reach_is_approached():
    """A kurtosis below 1 no image has; the nearest is taken, and it is finite."""
    images = noise(0)
    made = moments.set_kurtosis(images, np.full(3, 0.5))
    assert np.isfinite(made).all()
    assert (moments.standard_moments(made)[:, 3] < moments.standard_moments(images)[:, 3]).all()


def test_correlations_are_reached_beside_others():
    """Those among the bands exactly, those with bands that stay to the ridge."""
    bands, other, beside = noise(0), noise(1, (2, 1, 1.2)), noise(2)
    wanted = moments.correlations(other, other)
    made = moments.set_correlations(bands, wanted)
    np.testing.assert_allclose(moments.correlations(made, made), wanted, atol=1e-6)
    wanted_beside = moments.correlations(other, beside)
    made = moments.set_correlations(bands, wanted, beside, wanted_beside)
    np.testing.assert_allclose(moments.correlations(made, made), wanted, atol=2e-3)
    np.testing.assert_allclose(moments.correlations(made, beside), wanted_beside, atol=2e-3)


def test_bands_are_moved_as_little_as_can_be():
    """The mean squared change is the Bures distance of the covariances; a rotated square root moves them farther."""
    bands, wanted = noise(0), moments.correlations(noise(1), noise(1))
    made = moments.set_correlations(bands, wanted)
    found = moments.correlations(bands, bands)
    values, vectors = np.linalg.eigh(found)
    root = vectors * np.sqrt(values) @ vectors.T
    middle = np.linalg.eigvalsh(root @ wanted @ root)
    bures = np.trace(found) + np.trace(wanted) - 2 * np.sqrt(np.maximum(middle, 0)).sum()
    assert np.square(made - bands).mean(axis=(1, 2)).sum() == pytest.approx(bures, rel=1e-4)


def test_flat_images_stay_finite():
    """And have no variance to scale."""
    flat = np.zeros((2, 12, 12))
    wanted = moments.autocorrelation(noise(0)[:2], 2)
    assert np.isfinite(moments.set_autocorrelation(flat, wanted)).all()
    assert np.isfinite(moments.set_correlations(flat, np.eye(2))).all()
    assert np.abs(moments.set_skewness(flat, np.ones(2))).max() < 1e-12

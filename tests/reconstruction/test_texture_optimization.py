"""Texture optimisation: patches of the inputs, a falling energy, the same bits on any number of threads."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.texture_optimization import Exemplars, TextureOptimization, halved, optimize, pyramid
from warpfluid.views import Views

ANGLES = (0.0, 90.0)
SIZES = [4, 7, 16]


@pytest.fixture(scope="module")
def inputs(fire):
    """Front and side."""
    return Projector(ANGLES, fire.shape, device="cpu").project(fire)


@pytest.mark.parametrize("patch", SIZES)
def test_an_input_is_made_of_its_own_patches(inputs, patch):
    """A view that looks right already is left alone, mirrored beyond the last input."""
    moved = TextureOptimization(inputs, ANGLES, (0.0, 90.0, 179.9), patch=patch)
    rendered = np.stack([inputs[0], inputs[1], inputs[0, ::-1]])
    found = moved.transfer(rendered, np.ones(rendered.shape, bool))
    np.testing.assert_allclose(found, rendered, atol=2)


@pytest.mark.parametrize("patch", SIZES)
def test_a_blurred_view_gets_patches_of_the_inputs(inputs, patch):
    """The energy of every level falls, and each patch of the result is nearer to one of the inputs'."""
    blurred = gaussian_filter(inputs[0], 2)
    exemplars = [Exemplars(level, patch) for level in pyramid(inputs, patch)]
    made, energies = optimize(blurred, exemplars, patch)
    assert len(energies) == len(exemplars)
    for energy in energies:
        assert (np.diff(energy) < 0).all()
    known = np.lib.stride_tricks.sliding_window_view(inputs, (1, patch, patch)).reshape(-1, patch**2)

    def distance(image):
        windows = np.lib.stride_tricks.sliding_window_view(image, (patch, patch))[::4, ::4].reshape(-1, patch**2)
        return np.mean([np.square(known - window).sum(axis=1).min() for window in windows])

    assert distance(made) < 0.5 * distance(blurred)


def test_the_nearest_patch_is_that_of_an_exhaustive_search(inputs):
    """Principal components that hold nearly all find a patch hardly farther away than the best; black finds black."""
    exemplars = Exemplars(inputs, 8)
    rng = np.random.default_rng(0)
    asked = exemplars.patches[rng.integers(1, len(exemplars.patches), 50)] + rng.normal(0, 4, (50, 64))
    found = np.linalg.norm(asked - exemplars.patches[exemplars.nearest(asked)], axis=1)
    best = np.sqrt([np.square(exemplars.patches - patch).sum(axis=1).min() for patch in asked])
    assert np.mean(found / best) < 1.1
    assert np.median(found / best) < 1.02
    assert exemplars.nearest(np.zeros((3, 64))).tolist() == [0, 0, 0]


def test_threads_do_not_matter(inputs, monkeypatch):
    """One thread and three give the same bits; outside the mask all is black."""
    fan = tuple(float(angle) for angle in range(0, 180, 30))
    rendered = np.stack([gaussian_filter(inputs[i % 2], 1 + i / 4) for i in range(len(fan))])
    mask = np.broadcast_to(np.arange(inputs.shape[1])[:, None] > 10, rendered.shape)
    made = []
    for threads in (1, 3):
        monkeypatch.setenv("WARPFLUID_THREADS", str(threads))
        made.append(TextureOptimization(inputs, ANGLES, fan, patch=8).transfer(rendered, mask))
    np.testing.assert_array_equal(*made)
    assert not made[0][~mask].any()


def test_halving_keeps_the_mean():
    """Odd sizes are black beyond their edge."""
    images = np.random.default_rng(0).random((2, 7, 10))
    found = halved(images)
    assert found.shape == (2, 4, 5)
    assert found.sum() * 4 == pytest.approx(images.sum())


def test_a_patch_that_does_not_fit_is_refused(inputs):
    """With the largest that does."""
    with pytest.raises(ValueError, match="patch is 41, larger than the images of 40 pixels; take at most 40"):
        TextureOptimization(inputs, ANGLES, (0.0,), patch=41)


def test_the_energy_stays_high(fire, inputs):
    """As in Section 5: patches are too tight a constraint. The energy of Eq. 1 falls far less than with histograms."""
    views = Views(inputs, ANGLES)
    falls = {}
    for transfer in ("histograms", "texture-optimization"):
        options = ReconstructOptions.paper(transfer=transfer, iterations=5, angles=30, patch=8)
        found = reconstruct(views, options, device="cpu")
        assert np.isfinite(found.volume).all()
        assert found.volume.sum(dtype=np.float64) == pytest.approx(fire.sum(dtype=np.float64), rel=0.1)
        falls[transfer] = found.energies[-1, 0] / found.energies[1, 0]
    assert falls["texture-optimization"] > 2 * falls["histograms"]

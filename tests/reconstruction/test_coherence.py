"""Sequences: frames that follow from the ones before."""

from dataclasses import replace

import numpy as np
import pytest

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.coherence import follow
from warpfluid.reconstruction.em import reconstruct
from warpfluid.views import Views

OPTIONS = ReconstructOptions(iterations=3, angles=60)
ANGLES = (0.0, 90.0)


def rising(volume, voxels):
    """The volume some voxels higher."""
    out = np.zeros_like(volume)
    out[:, :, voxels:] = volume[:, :, : volume.shape[2] - voxels]
    return out


def views_of(volume, device):
    return Views(Projector(ANGLES, volume.shape, device=device).project(volume), ANGLES)


@pytest.fixture(scope="module")
def first(fire, device):
    """The first frame, and its views."""
    views = views_of(fire, device)
    return reconstruct(views, OPTIONS, device=device).volume, views


def test_a_carried_frame_is_exact_and_quick(fire, first, device):
    """One iteration, inputs exact, and nearer to the moved frame before than a frame alone."""
    later = views_of(rising(fire, 2), device)
    result = follow(*first, later, OPTIONS, device=device)
    assert result.energies.shape == (1, 2)
    error = result.render(ANGLES) - later.images
    assert 20 * np.log10(255 / np.sqrt(np.mean(error**2))) > 50
    alone = reconstruct(later, OPTIONS, device=device)
    moved = rising(first[0], 2)

    def distance(volume):
        return np.abs(volume - moved).sum() / moved.sum()

    assert distance(result.volume) < 0.6 * distance(alone.volume)


def test_a_frame_that_is_drawn_to_another(fire, first, device):
    """By nothing it is the carried one; wholly, what was carried does not matter; between, it is nearer to both."""
    later = views_of(rising(fire, 1), device)
    other = reconstruct(later, replace(OPTIONS, seed=7), device=device).volume
    carried = follow(*first, later, OPTIONS, device=device).volume
    none, half, whole = (
        follow(*first, later, OPTIONS, towards=(other, weight), device=device).volume for weight in (0.0, 0.5, 1.0)
    )
    np.testing.assert_array_equal(none, carried)
    from_nothing = follow(0 * first[0], first[1], later, OPTIONS, towards=(other, 1.0), device=device).volume
    np.testing.assert_allclose(from_nothing, whole, rtol=0.01, atol=1e-3)
    apart = np.abs(carried - whole).sum()
    assert max(np.abs(half - carried).sum(), np.abs(half - whole).sum()) < 0.75 * apart


def test_new_matter_grows(fire, first, device):
    """A flame that appears where the carried volume is empty is there, not black."""
    grown = rising(fire, 1)
    grown[4:10, 4:10, 4:12] += 0.5 * fire.max()
    later = views_of(grown, device)
    result = follow(*first, later, OPTIONS, device=device)
    error = result.render(ANGLES) - later.images
    assert 20 * np.log10(255 / np.sqrt(np.mean(error**2))) > 35
    assert result.volume[4:10, 4:10, 4:12].sum() > 0.6 * grown[4:10, 4:10, 4:12].sum()


def test_a_cut_starts_anew(fire, first, device):
    """Another scene, or a black frame, is not followed."""
    elsewhere = np.zeros_like(fire)
    elsewhere[:14] = fire[-14:]
    assert follow(*first, views_of(np.ascontiguousarray(elsewhere), device), OPTIONS, device=device) is None
    black = Views(np.zeros_like(first[1].images), ANGLES)
    assert follow(*first, black, OPTIONS, device=device) is None


def test_same_bits_and_any_scale(fire, first, device):
    """Deterministic, and pixel values may have any unit."""
    later = views_of(rising(fire, 1), device)
    one, two = (follow(*first, later, OPTIONS, device=device).volume for _ in range(2))
    np.testing.assert_array_equal(one, two)
    small = [Views(v.images / 255, ANGLES, white=1.0) for v in (first[1], later)]
    scaled = follow(first[0] / 255, *small, OPTIONS, device=device).volume
    np.testing.assert_allclose(scaled * 255, one, atol=2e-3 * one.max())


def test_one_view_is_followed(fire, device):
    """The front alone carries a volume, too."""
    views = [Views(views_of(rising(fire, k), device).images[:1], (0.0,)) for k in (0, 1)]
    options = replace(OPTIONS, shoulder=0.0)
    volume = reconstruct(views[0], options, device=device).volume
    result = follow(volume, *views, options, device=device)
    error = result.render((0,)) - views[1].images
    assert 20 * np.log10(255 / np.sqrt(np.mean(error**2))) > 50

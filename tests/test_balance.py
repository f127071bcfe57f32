"""Balancing: measured views become exact and darkness stays dark."""

import numpy as np
import pytest
import warp as wp

from warpfluid.balance import Balancing
from warpfluid.projector import Projector


def balanced(volume, angles, images, sweeps, device, **options):
    hull = np.ones(volume.shape, np.float32)
    projectors = [Projector([angle], volume.shape, hull=hull, device=device) for angle in angles]
    array = wp.array(volume, dtype=float, device=device)
    returned = Balancing(images, projectors).apply(array, sweeps, **options)
    assert returned is array
    return array.numpy()


def test_one_sweep_solves_two_orthogonal_views(fire, device):
    """From a constant it gives the product front * side / total, the maximum of entropy."""
    front, side = fire.sum(axis=1) + 5, fire.sum(axis=0) + 5
    found = balanced(np.ones_like(fire), [0, 90], np.stack([front, side]), 5, device)
    np.testing.assert_allclose(found, front[:, None] * side[None] / front.sum(axis=0), rtol=1e-4)


def test_measured_views_become_exact(fire, device):
    """Three views at odd angles, from a volume that only resembles the truth."""
    angles = [10, 55, 130]
    images = Projector(angles, fire.shape, device=device).project(fire)
    noise = np.exp(0.3 * np.random.default_rng(0).standard_normal(fire.shape)).astype(np.float32)
    errors = []
    for sweeps in (0, 1, 5, 20):
        found = balanced(fire * noise, angles, images, sweeps, device)
        errors.append(np.abs(Projector(angles, fire.shape, device=device).project(found) - images).mean())
        assert found.min() >= 0
        assert not found[fire == 0].any()
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.02 * errors[0]


def test_a_right_volume_stays(fire, device):
    """Every ratio is 1."""
    images = Projector([0, 70], fire.shape, device=device).project(fire)
    np.testing.assert_allclose(balanced(fire, [0, 70], images, 3, device), fire, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("power", "factor"), [(1.0, 2.0), (0.5, 2.0**0.5), (0.0, 1.0)])
def test_power_makes_it_milder(power, factor, device):
    """A picture twice as bright doubles the volume, or less."""
    volume = np.full((10, 10, 4), 0.5, np.float32)
    images = Projector([0], volume.shape, device=device).project(volume)
    found = balanced(volume, [0], 2 * images, 1, device, power=power)
    np.testing.assert_allclose(found, factor * volume, rtol=1e-5)


def test_corrections_are_capped(device):
    """A faint trace does not explode in one sweep."""
    volume = np.full((10, 10, 4), 0.01, np.float32)
    images = np.full((1, 10, 4), 200, np.float32)
    found = balanced(volume, [0], images, 1, device)
    np.testing.assert_allclose(found, 4 * volume, rtol=1e-5)

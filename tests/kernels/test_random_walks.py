"""Random walks: what they leave is what they say, and the same whatever walks side by side."""

import numpy as np
import pytest
import warp as wp

from warpfluid.device import pick_device
from warpfluid.kernels.tomography import stochastic
from warpfluid.projector import Projector, directions

ANGLES = (0.0, 33.0, 90.0, 140.0)


def walked(fire, device, *, sweeps=3, chains=4, steps=300, footprint="box", weights=None, **kwargs):
    """Volume (x, z, y), residual and accepted quanta after some sweeps over a fire, and the problem."""
    truth = np.ascontiguousarray(fire[6:40, 4:, :30])
    hull = truth > 0
    projector = Projector(ANGLES, truth.shape, width=48, corner=(6, 4), footprint=footprint, device=device)
    images = projector.project(truth)
    at = pick_device(device)
    weights = np.ones(len(ANGLES)) if weights is None else weights
    volume = wp.zeros((truth.shape[2], *truth.shape[:2]), dtype=float, device=at)
    residual = wp.array(np.ascontiguousarray(-images.transpose(2, 0, 1)), dtype=float, device=at)
    inside = wp.array(np.ascontiguousarray(hull.transpose(2, 0, 1)), dtype=wp.uint8, device=at)
    total = 0
    for sweep in range(sweeps):
        shift = 2 * (sweep % 2)
        slabs = len(range(-shift, truth.shape[2], stochastic.SLAB))
        accepted = wp.zeros(slabs, dtype=int, device=at)
        places = np.random.default_rng(0).integers((*truth.shape[:2], 4), size=(slabs * chains, 3))
        stochastic.walk(
            volume,
            residual,
            inside,
            directions(np.array(ANGLES), at),
            wp.array(weights, dtype=float, device=at),
            wp.array(np.full(slabs, steps), dtype=int, device=at),
            wp.array(places, dtype=int, device=at),
            accepted,
            sweep=sweep,
            shift=shift,
            corner=(6, 4),
            footprint=footprint,
            **{"quantum": 2.0, "sad": 0.5, "seed": 3} | kwargs,
        )
        total += int(accepted.numpy().sum())
    return volume.numpy().transpose(1, 2, 0), residual.numpy().transpose(1, 2, 0), total, (projector, images, hull)


@pytest.mark.parametrize("footprint", ["box", "joseph"])
def test_keeps_its_books(fire, footprint, device):
    """The residual stays rendered minus wanted, light stays in the hull and at or above 0."""
    volume, residual, accepted, (projector, images, hull) = walked(fire, device, footprint=footprint)
    assert accepted > 100
    assert volume.min() >= 0
    assert not volume[~hull].any()
    expected = projector.project(np.ascontiguousarray(volume)) - images
    np.testing.assert_allclose(residual, expected, atol=1e-3)


@pytest.mark.parametrize("weights", [None, [1.0, 5.0, 0.5, 2.0]])
def test_the_energy_falls(fire, weights, device):
    """With every sweep: squares weigh what they should, and so do the differences, by NumPy."""

    def energy(volume, residual):
        squares = (np.square(residual, dtype=np.float64).sum(axis=(1, 2)) * (weights or [1.0] * 4)).sum()
        return squares + 20.0 * sum(np.abs(np.diff(volume.astype(np.float64), axis=k)).sum() for k in range(3))

    found = [energy(*walked(fire, device, sweeps=n, sad=20.0, weights=weights)[:2]) for n in range(4)]
    assert (np.diff(found) < 0).all()
    small = [energy(*walked(fire, device, sweeps=n, sad=20.0, weights=weights, quantum=0.01)[:2]) for n in range(3)]
    assert (np.diff(small) < 0).all()


@pytest.mark.parametrize("threads", ["1", "3", "8"])
def test_any_number_of_threads_gives_the_same_bits(fire, threads, monkeypatch, device):
    """A thread owns what it writes."""
    expected = walked(fire, device)
    monkeypatch.setenv("WARPFLUID_THREADS", threads)
    found = walked(fire, device)
    for a, b in zip(expected[:3], found[:3], strict=True):
        np.testing.assert_array_equal(a, b)


def test_heat_lets_the_energy_rise(fire, device):
    """More proposals are applied, the books are kept all the same; without heat the walk is pure descent, see above."""
    cold, warm = (walked(fire, device, sad=5.0, heat=heat, steps=3000) for heat in (0.0, 50.0))
    assert warm[2] > 1.5 * cold[2]
    projector, images, _ = warm[3]
    np.testing.assert_allclose(warm[1], projector.project(np.ascontiguousarray(warm[0])) - images, atol=1e-3)
    assert warm[0].min() >= 0


def test_another_seed_walks_elsewhere(fire, device):
    """Seeds of 32 bits, all of which count."""
    volumes = [walked(fire, device, sweeps=1, seed=seed)[0] for seed in (0, 1, 2**31, 2**32 - 1)]
    for i, volume in enumerate(volumes):
        assert all((volume != other).any() for other in volumes[:i])


@pytest.mark.parametrize(("target", "weight"), [(10.0, 1.0), (10.0, 4.0), (3.0, 4.0)])
def test_a_lone_voxel_has_a_closed_form(target, weight, device):
    """(v - t)^2 in two views and six neighbours of nothing: v is t - 3 weight / 2, or 0."""
    at = pick_device(device)
    hull = np.zeros((5, 5, 5), np.uint8)
    hull[2, 2, 2] = 1
    volume = wp.zeros((5, 5, 5), dtype=float, device=at)
    residual = np.zeros((5, 2, 5), np.float32)
    residual[2, :, 2] = -target
    residual = wp.array(residual, dtype=float, device=at)
    for sweep in range(2):
        stochastic.walk(
            volume,
            residual,
            wp.array(hull, dtype=wp.uint8, device=at),
            directions(np.array([0.0, 90.0]), at),
            wp.array([1.0, 1.0], dtype=float, device=at),
            wp.array([30000, 0], dtype=int, device=at),
            wp.zeros((2, 3), dtype=int, device=at),
            wp.zeros(2, dtype=int, device=at),
            quantum=0.125,
            sad=weight,
            seed=0,
            sweep=sweep,
        )
    assert volume.numpy()[2, 2, 2] == pytest.approx(max(target - 1.5 * weight, 0), abs=0.07)
    assert volume.numpy().sum() == volume.numpy()[2, 2, 2]


def test_chains_are_shared_out_evenly(device):
    """An error says how many there must be."""
    at = pick_device(device)
    arrays = [wp.zeros((12, *shape), dtype=float, device=at) for shape in ((5, 5), (2, 5))]
    arrays += [wp.zeros((12, 5, 5), dtype=wp.uint8, device=at), directions(np.array([0.0, 90.0]), at)]
    arrays += [wp.zeros(2, dtype=float, device=at)]
    arrays += [wp.zeros(shape, dtype=int, device=at) for shape in (3, (4, 3), 3)]
    with pytest.raises(ValueError, match="as many for each of 3 slabs"):
        stochastic.walk(*arrays, quantum=1.0, sad=1.0, seed=0, sweep=0)

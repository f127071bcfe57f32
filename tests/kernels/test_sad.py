"""The sum of absolute differences and the steps of its solver, against NumPy."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.tomography import sad

SHAPES = [(5, 7, 60), (1, 1, 1), (3, 1, 49), (2, 4, 3)]


def differences(volume):
    """What follows minus what is there, 0 at the end, along x, z and y."""
    pads = [[(0, int(k == axis)) for k in range(3)] for axis in range(3)]
    return np.stack([np.diff(np.pad(volume, pad, mode="edge"), axis=k) for k, pad in enumerate(pads)])


def transpose(dual):
    """The transpose of the differences, by hand."""
    total = np.zeros(dual.shape[1:])
    for axis, part in enumerate(dual):
        part = part.copy()
        part[(slice(None),) * axis + (-1,)] = 0
        total -= part
        total += np.roll(part, 1, axis=axis)
    return total


def arrays(shape, seed=0):
    rng = np.random.default_rng(seed)
    return rng.random(shape).astype(np.float32), rng.uniform(-1, 1, (3, *shape)).astype(np.float32)


def on(device, array):
    return wp.array(array, dtype=float, device=device)


@pytest.mark.parametrize("shape", SHAPES)
def test_sum(shape, device):
    """Every pair of neighbours counts once."""
    volume, _ = arrays(shape)
    expected = np.abs(differences(volume.astype(np.float64))).sum()
    assert sad.sad(on(device, volume)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_dual_step(shape, device):
    """Along the differences, and never beyond the weight."""
    volume, dual = arrays(shape)
    expected = np.clip(dual + 0.7 * differences(volume), -0.9, 0.9)
    dual = on(device, dual)
    sad.raise_dual(on(device, volume), dual, step=0.7, weight=0.9)
    np.testing.assert_allclose(dual.numpy(), expected, atol=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_primal_step(shape, device):
    """Against the gradient and the transpose of the differences, inside the hull, nowhere negative."""
    volume, dual = arrays(shape)
    for axis in range(3):
        dual[(axis, *(slice(None),) * axis, -1)] = 0
    rng = np.random.default_rng(1)
    gradient, hull = rng.uniform(-1, 1, shape).astype(np.float32), (rng.random(shape) < 0.8).astype(np.float32)
    expected = np.maximum(volume - 0.3 * (gradient + transpose(dual.astype(np.float64))), 0) * hull
    now, ahead = on(device, volume), on(device, np.full(shape, np.nan))
    sad.lower_primal(on(device, gradient), on(device, dual), on(device, hull), now, ahead, step=0.3)
    np.testing.assert_allclose(now.numpy(), expected, atol=1e-6)
    np.testing.assert_allclose(ahead.numpy(), 2 * expected - volume, atol=2e-6)


def test_step_of_views(device):
    """The proximal step of half the dual's square, worked out by hand."""
    dual, rendered, wanted = (np.random.default_rng(k).random((2, 5, 9)).astype(np.float32) for k in range(3))
    found = sad.raise_views(on(device, dual), on(device, rendered), on(device, wanted), step=0.4)
    np.testing.assert_allclose(found.numpy(), (dual + 0.4 * (rendered - wanted)) / 1.2, rtol=1e-6)

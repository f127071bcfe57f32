"""Least squares against closed forms and a dense solver."""

import numpy as np
import pytest
import warp as wp

from warpfluid.projector import Projector
from warpfluid.reconstruction.lsm import LeastSquares, initial_volume


def solve(projector, images, steps, **options):
    """The volume after some steps from zero, and the residual that comes with it."""
    volume = wp.zeros(projector.shape, dtype=float, device=projector.device)
    residual = wp.array(images, dtype=float, device=projector.device)
    LeastSquares(projector, **options).improve(volume, residual, steps)
    return volume.numpy(), residual.numpy()


def dense(projector):
    """B as a matrix (pixels, voxels), column by column; columns outside the hull are zero."""
    units = np.eye(np.prod(projector.shape), dtype=np.float32).reshape(-1, *projector.shape)
    hull = projector.hull.numpy()
    return np.stack([projector.project(unit * hull).ravel() for unit in units], axis=1).astype(np.float64)


@pytest.mark.parametrize("steps", [2, 3, 12])
def test_two_orthogonal_views_have_a_closed_form(steps, device):
    """Without a hull the solution of least norm is row / n + column / n - total / n^2, the paper's grid artifact."""
    n, heights = 23, 50
    volume = np.random.default_rng(0).random((n, n, heights)).astype(np.float32)
    projector = Projector([0, 90], volume.shape, device=device)
    front, side = volume.sum(axis=1, dtype=np.float64), volume.sum(axis=0, dtype=np.float64)
    expected = front[:, None] / n + side[None] / n - front.sum(axis=0) / n**2
    found, _ = solve(projector, np.stack([front, side]), steps)
    np.testing.assert_allclose(found, expected, atol=2e-5)


@pytest.mark.parametrize("angles", [[0, 90], [0, 50, 110], [10, 40, 75, 120, 160]])
def test_agrees_with_a_dense_solver_inside_a_hull(angles, device):
    """Least squares of least norm among the volumes that are zero outside."""
    rng = np.random.default_rng(1)
    shape = (6, 6, 2)
    hull = (rng.random(shape) < 0.6).astype(np.float32)
    projector = Projector(angles, shape, hull=hull, device=device)
    images = rng.random(projector.image_shape).astype(np.float32)
    expected = np.linalg.lstsq(dense(projector), images.ravel().astype(np.float64), rcond=1e-8)[0].reshape(shape)
    found, _ = solve(projector, images, 80)
    assert (found[hull == 0] == 0).all()
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


def test_weights_count_the_squared_error_of_a_view(device):
    """The normal equations of weighted least squares hold."""
    rng = np.random.default_rng(2)
    projector = Projector(np.arange(0, 180, 15), (6, 6, 1), device=device)
    images = rng.random(projector.image_shape).astype(np.float32)
    weights = rng.uniform(0.5, 5, len(images))
    root = np.repeat(np.sqrt(weights), images[0].size)
    expected = np.linalg.lstsq(dense(projector) * root[:, None], images.ravel() * root, rcond=None)[0]
    found, _ = solve(projector, images, 150, weights=weights)
    np.testing.assert_allclose(found.ravel(), expected, atol=2e-3 * np.abs(expected).max())


def test_the_ramp_leads_to_the_same_volume(device):
    """A preconditioner changes the way, not the goal."""
    rng = np.random.default_rng(3)
    projector = Projector(np.arange(0, 180, 15), (6, 6, 1), device=device)
    images = rng.random(projector.image_shape).astype(np.float32)
    expected = np.linalg.lstsq(dense(projector), images.ravel().astype(np.float64), rcond=None)[0]
    found, _ = solve(projector, images, 150, ramp=True)
    np.testing.assert_allclose(found.ravel(), expected, atol=2e-3 * np.abs(expected).max())


def test_the_ramp_reaches_fine_detail_sooner(fire, device):
    """After five steps from a full fan the error is a fraction of what plain steps leave."""
    projector = Projector(np.arange(0, 180, 3), fire.shape, device=device)
    images = projector.project(fire)
    errors = {ramp: np.linalg.norm(solve(projector, images, 5, ramp=ramp)[0] - fire) for ramp in (False, True)}
    assert errors[True] < 0.7 * errors[False]


@pytest.mark.parametrize("ramp", [False, True])
@pytest.mark.parametrize("steps", [0, 1, 5, 40])
def test_the_residual_is_what_is_left(fire, steps, ramp, device):
    """Targets minus the rendered volume: the energy comes for nothing."""
    hull = (fire > 0).any(axis=2, keepdims=True) * np.ones(fire.shape, np.float32)
    projector = Projector([0, 40, 90, 140], fire.shape, hull=hull.astype(np.float32), device=device)
    images = projector.project(fire)
    volume, residual = solve(projector, images, steps, ramp=ramp)
    np.testing.assert_allclose(residual, images - projector.project(volume), atol=2e-5 * images.max())


def test_every_step_lowers_the_energy(fire, device):
    """CGLS minimises over a growing space."""
    projector = Projector([0, 30, 90], fire.shape, device=device)
    images = projector.project(fire)
    energies = [np.square(solve(projector, images, steps)[1], dtype=np.float64).sum() for steps in range(8)]
    assert (np.diff(energies) < 0).all()


def test_a_solved_problem_stays_solved(device):
    """No division by a vanished gradient, and steps upon steps do not undo a solution."""
    projector = Projector([0, 90], (9, 9, 5), device=device)
    volume, residual = solve(projector, np.zeros(projector.image_shape, np.float32), 5)
    assert not volume.any()
    assert not residual.any()
    images = projector.project(np.ones(projector.shape, np.float32))
    volume, residual = solve(projector, images, 300)
    np.testing.assert_allclose(volume, 1, atol=1e-5)


def test_initial_volume(fire, device):
    """Zero outside the hull, nowhere negative unless asked for, and the images stay as they are."""
    angles = [0, 90]
    silhouettes = Projector(angles, fire.shape, device=device).project(fire) > 1
    hull = (silhouettes[0][:, None] & silhouettes[1][None]).astype(np.float32)
    projector = Projector(angles, fire.shape, hull=hull, device=device)
    pictures = projector.project(fire * hull)
    images = wp.array(pictures, dtype=float, device=device)
    clipped = initial_volume(projector, images, steps=12).numpy()
    free = initial_volume(projector, images, steps=12, non_negative=False).numpy()
    np.testing.assert_array_equal(images.numpy(), pictures)
    np.testing.assert_array_equal(clipped, np.maximum(free, 0))
    assert free.min() < 0
    assert not clipped[hull == 0].any()

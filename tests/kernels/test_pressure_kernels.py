"""The kernels of the pressure step against NumPy, in arrays with NaN all around them."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.poisson import coefficients, multigrid, pressure
from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP
from warpfluid.simulation.state import face_shape

SHAPES = [(1, 1, 1), (2, 3, 48), (3, 1, 49), (4, 5, 100)]
SIDES = [SIX(OPEN, CLOSED, WRAP, WRAP, CLOSED, OPEN), SIX(WRAP, WRAP, CLOSED, OPEN, WRAP, WRAP)]
MARGIN = 4096


class Guarded:
    """Arrays that lie in a sea of NaN: what is read beyond them shows, and so does what is written."""

    def __init__(self, device):
        self.device, self.seas = device, []

    def __call__(self, values):
        values = np.asarray(values, np.float32)
        sea = np.full(values.size + 2 * MARGIN, np.nan, np.float32)
        sea[MARGIN:-MARGIN] = values.ravel()
        self.seas.append(wp.array(sea, device=self.device))
        return self.seas[-1][MARGIN:-MARGIN].reshape(values.shape)

    def check(self):
        for sea in self.seas:
            values = sea.numpy()
            assert np.isnan(values[:MARGIN]).all()
            assert np.isnan(values[-MARGIN:]).all()
            assert np.isfinite(values[MARGIN:-MARGIN]).all()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_flux(shape, axis, device):
    """Differences over a voxel, with and without solids."""
    rng, guarded = np.random.default_rng(0), Guarded(device)
    u, open, solid = (rng.random(face_shape(shape, axis)) for _ in range(3))
    out = guarded(np.ones(shape))
    pressure.add_flux(guarded(u), axis=axis, out=out)
    np.testing.assert_allclose(out.numpy(), 1 + np.diff(u, axis=axis), atol=1e-6)
    pressure.add_flux(guarded(u), axis=axis, open=guarded(open), solid=guarded(solid), out=out)
    total = u + open * u + (1 - open) * solid
    np.testing.assert_allclose(out.numpy(), 1 + np.diff(total, axis=axis), atol=1e-6)
    guarded.check()


@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_gradient(shape, axis, sides, device):
    """Differences over a face, and what lies beyond the sides; with coefficients that say the same, the same."""
    rng, guarded = np.random.default_rng(0), Guarded(device)
    p, u, open = rng.random(shape), rng.random(face_shape(shape, axis)), rng.uniform(0.1, 1, face_shape(shape, axis))
    low, high = sides[2 * axis], sides[2 * axis + 1]
    if low == WRAP:
        np.moveaxis(open, axis, 0)[-1] = np.moveaxis(open, axis, 0)[0]
    ghosts = [np.moveaxis(p, axis, 0)[end] * (-1 if side == OPEN else 1) for end, side in ((0, low), (-1, high))]
    if low == WRAP:
        ghosts = ghosts[::-1]
    ends = np.concatenate([ghosts[0][None], np.moveaxis(p, axis, 0), ghosts[1][None]])
    expected = u - np.moveaxis(np.diff(ends, axis=0), 0, axis)
    found = pressure.subtract_gradient(guarded(p), axis=axis, sides=sides, velocity=guarded(u))
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-6)
    for share in (None, guarded(open)):
        coefficient = guarded(np.zeros(u.shape))
        coefficients.face_coefficient(axis=axis, sides=sides, open=share, mass=guarded(np.ones(shape)), out=coefficient)
        arguments = {"coefficient": coefficient, "open": share, "velocity": guarded(u)}
        found = pressure.subtract_gradient(guarded(p), axis=axis, sides=sides, **arguments)
        np.testing.assert_allclose(found.numpy(), expected, atol=1e-6)
    guarded.check()


@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_stencil_stays_within_its_arrays(shape, sides, device):
    """And its three uses fit together: b - A p, and a Jacobi step of that over the sum of the coefficients."""
    rng, guarded = np.random.default_rng(0), Guarded(device)
    p, b, scale = (guarded(rng.random(shape)) for _ in range(3))
    faces = [guarded(np.zeros(face_shape(shape, axis))) for axis in range(3)]
    for axis, out in enumerate(faces):
        coefficients.face_coefficient(axis=axis, sides=sides, out=out)
    image, left, scaled, stepped = (guarded(np.zeros(shape)) for _ in range(4))
    multigrid.apply(p, *faces, sides=sides, out=image)
    multigrid.apply(p, *faces, sides=sides, right=b, out=left)
    multigrid.apply(p, *faces, sides=sides, right=b, scale=scale, out=scaled)
    multigrid.apply(p, *faces, sides=sides, right=b, step=0.5, out=stepped)
    total = sum(
        np.take(c.numpy(), range(n), axis) + np.take(c.numpy(), range(1, n + 1), axis)
        for axis, (c, n) in enumerate(zip(faces, shape, strict=True))
    )
    np.testing.assert_allclose(left.numpy(), b.numpy() - image.numpy(), atol=1e-5)
    np.testing.assert_allclose(scaled.numpy(), scale.numpy() * left.numpy(), atol=1e-5)
    np.testing.assert_allclose(stepped.numpy(), p.numpy() + 0.5 * left.numpy() / total, atol=1e-5)
    guarded.check()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_combine(shape, axis, device):
    """A small matrix along one axis; with a scale the sums are added."""
    rng, guarded, n = np.random.default_rng(0), Guarded(device), 5
    source, weight = rng.integers(0, shape[axis], (n, 3)), rng.random((n, 3)).astype(np.float32)
    values = rng.random(shape)
    expected = np.moveaxis((np.moveaxis(values, axis, 0)[source] * weight[..., None, None]).sum(axis=1), 0, axis)
    taps = wp.array(source, dtype=int, device=device), wp.array(weight, device=device)
    out, scale = guarded(np.ones(expected.shape)), guarded(np.full(expected.shape, 2.0))
    multigrid.combine(guarded(values), *taps, axis=axis, out=out)
    np.testing.assert_allclose(out.numpy(), expected, atol=1e-5)
    multigrid.combine(guarded(values), *taps, axis=axis, scale=scale, out=out)
    np.testing.assert_allclose(out.numpy(), 3 * expected, atol=1e-5)
    guarded.check()

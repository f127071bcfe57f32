"""Ramps, centres and soft balls against NumPy."""

import numpy as np
import pytest
import warp as wp

from warpfluid.kernels.fluid.centres import measure_speed, to_centres
from warpfluid.kernels.forces.ramp import look_up
from warpfluid.kernels.forces.reach import make_reach
from warpfluid.kernels.sides import OPEN, SIX, WRAP

SHAPE = (5, 4, 53)


def draw(shape, device, seed=0):
    values = np.random.default_rng(seed).uniform(-1, 3, shape).astype(np.float32)
    return values, wp.array(values, dtype=float, device=device)


@pytest.mark.parametrize("pairs", [([0.5], [2.0]), ([0.0, 1.0], [0.0, 4.0]), ([-0.5, 0.0, 2.0, 2.5], [1, -3, 7, 0])])
def test_a_ramp_is_interpolated(device, pairs):
    """Lines between the pairs, constant beyond them."""
    values, field = draw(SHAPE, device)
    found = look_up(field, inputs=np.array(pairs[0]), values=np.array(pairs[1]), scale=1.5).numpy()
    np.testing.assert_allclose(found, np.interp(1.5 * values, *pairs), atol=2e-5)


def test_a_constant_ramp_is_its_constant(device):
    """To the bit, wherever the field is."""
    _, field = draw(SHAPE, device)
    found = look_up(field, inputs=np.array([0.0, 0.3, 1.0]), values=np.full(3, 0.7)).numpy()
    np.testing.assert_allclose(found, np.float32(0.7), rtol=2e-7)
    exact = look_up(field, inputs=np.array([0.0]), values=np.array([0.7])).numpy()
    assert (exact == np.float32(0.7)).all()


def test_a_ramp_must_rise(device):
    """A step that falls is refused."""
    _, field = draw(SHAPE, device)
    with pytest.raises(ValueError, match="which rise"):
        look_up(field, inputs=np.array([1.0, 0.0]), values=np.array([0.0, 1.0]))


def test_the_mean_of_two_faces(device):
    """Each component, and the speed of all."""
    parts = [draw(tuple(n + (k == axis) for k, n in enumerate(SHAPE)), device, axis) for axis in range(3)]
    centred = []
    for axis, (values, faces) in enumerate(parts):
        low, high = (np.take(values, np.arange(SHAPE[axis]) + k, axis) for k in (0, 1))
        centred.append((low + high) / 2)
        np.testing.assert_allclose(to_centres(faces, axis=axis).numpy(), centred[-1], atol=1e-6)
    speed = measure_speed(*(faces for _, faces in parts)).numpy()
    np.testing.assert_allclose(speed, np.sqrt(sum(part**2 for part in centred)), atol=1e-5)


@pytest.mark.parametrize("side", [OPEN, WRAP])
def test_a_soft_ball(device, side):
    """A Gaussian about the centre, on the shortest way where the box wraps."""
    centre, out = (0.5, 1.0, 50.0), wp.empty(SHAPE, dtype=float, device=device)
    found = make_reach(out, centre=centre, radius=2.0, sides=SIX(*[side] * 6)).numpy()
    squares = 0
    for axis, n in enumerate(SHAPE):
        way = np.abs(np.arange(n) - centre[axis])
        way = np.minimum(way, n - way) if side == WRAP else way
        squares = squares + way.reshape([-1 if k == axis else 1 for k in range(3)]) ** 2
    np.testing.assert_allclose(found, np.exp(-squares / 8), rtol=1e-4, atol=1e-30)
    with pytest.raises(ValueError, match="radius is 0"):
        make_reach(out, centre=centre, radius=0, sides=SIX(*[side] * 6))

"""Damping, dissolving and cooling against their closed forms."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from warpfluid.kernels.fluid.decay import decay, make_mask, radiate, thin

SHAPE = (17, 5, 50)


def random_field(device, low=-1.0, high=2.0):
    field = np.random.default_rng(0).uniform(low, high, SHAPE)
    return wp.array(field, dtype=float, device=device)


@given(rate=st.floats(0, 20), time_step=st.floats(0, 2), parts=st.integers(1, 4))
@settings(max_examples=20)
def test_decay_is_exponential(rate, time_step, parts):
    """In one step or in several."""
    field = random_field("cpu")
    expected = field.numpy().astype(float) * np.exp(-rate * time_step)
    for _ in range(parts):
        decay(field, rate=rate, time_step=time_step / parts)
    np.testing.assert_allclose(field.numpy(), expected, rtol=1e-5, atol=1e-30)


def test_decay_on_every_device(device):
    """Half of it after ln 2 over the rate."""
    field = random_field(device)
    before = field.numpy().copy()
    assert decay(field, rate=2.0, time_step=np.log(2) / 2) is field
    np.testing.assert_allclose(field.numpy(), before / 2, rtol=1e-6)


@pytest.mark.parametrize("steps", [1, 5])
def test_cooling_solves_the_law(steps, device):
    """As an integrator of SciPy's does it; hot gas cools first, and nothing below 0 changes."""
    field = random_field(device)
    before = field.numpy().astype(float)
    for _ in range(steps):
        radiate(field, rate=3.0, hottest=1.5, time_step=0.5 / steps)
    above = before > 0
    law = solve_ivp(lambda _, t: -3 * 1.5 * (t / 1.5) ** 4, (0, 0.5), before[above], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(field.numpy()[above], law.y[:, -1], rtol=1e-5)
    np.testing.assert_array_equal(field.numpy()[~above], before[~above].astype(np.float32))


def test_rate_is_the_hottest_gas_first_loss(device):
    """A share of its temperature a second."""
    field = wp.full(SHAPE, 2.0, dtype=float, device=device)
    radiate(field, rate=0.5, hottest=2.0, time_step=0.01)
    np.testing.assert_allclose(field.numpy(), 2 * (1 - 0.5 * 0.01), rtol=1e-4)


def test_no_rate_keeps_the_bits(device):
    """Nor does no time change one."""
    field = random_field(device)
    before = field.numpy().copy()
    for rate, time_step in ((0.0, 1.0), (1.0, 0.0)):
        decay(field, rate=rate, time_step=time_step)
        radiate(field, rate=rate, hottest=1.0, time_step=time_step)
    np.testing.assert_array_equal(field.numpy(), before)


def test_a_mask_is_clipped(device):
    """0 where nothing is, 1 from the reference on."""
    field = random_field(device, -10, 100)
    np.testing.assert_allclose(make_mask(field, reference=40).numpy(), np.clip(field.numpy() / 40, 0, 1), rtol=1e-6)


def test_refuses_senseless_numbers(device):
    """Each is named."""
    field = random_field(device)
    with pytest.raises(ValueError, match="rate"):
        decay(field, rate=-1.0, time_step=1.0)
    with pytest.raises(ValueError, match="rate"):
        radiate(field, rate=float("inf"), hottest=1.0, time_step=1.0)
    with pytest.raises(ValueError, match="hottest"):
        radiate(field, rate=1.0, hottest=0.0, time_step=1.0)
    with pytest.raises(ValueError, match="reference"):
        make_mask(field, reference=0.0)


def test_thin_is_its_exponential(device):
    """A voxel whose gas doubles holds half as much; where nothing swells the bits stay."""
    values = np.random.default_rng(4).random((5, 6, 40)).astype(np.float32)
    divergence = np.zeros_like(values)
    divergence[2:] = np.log(2) / 0.1
    field = wp.array(values, dtype=float, device=device)
    thin(field, divergence=wp.array(divergence, dtype=float, device=device), time_step=0.1)
    np.testing.assert_allclose(field.numpy()[2:], values[2:] / 2, rtol=1e-5)
    np.testing.assert_array_equal(field.numpy()[:2], values[:2])

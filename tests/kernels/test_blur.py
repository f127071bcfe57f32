"""The blur against SciPy's, which treats the border as we do."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from warpfluid.kernels.blur import blur

SHAPES = [(16, 16, 50), (17, 13, 48), (3, 5, 2), (1, 1, 1), (20, 9, 97)]
SIGMAS = [0.4, 1.5, 3.0, (0.8, 0.8, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 5.0), (2.0, 0.5, 1.0)]


def blurred(field, sigma, device):
    return blur(wp.array(field, dtype=float, device=device), sigma).numpy()


def random_field(shape, seed=0):
    return np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


@pytest.mark.parametrize("sigma", SIGMAS)
@pytest.mark.parametrize("shape", SHAPES)
def test_agrees_with_scipy(shape, sigma, device):
    """Every axis, every width, also taps that reach beyond both ends of the volume."""
    field = random_field(shape)
    expected = gaussian_filter(field.astype(np.float64), sigma, mode="reflect", truncate=4.0)
    np.testing.assert_allclose(blurred(field, sigma, device), expected, atol=2e-6, rtol=0)


@given(
    shape=st.tuples(st.integers(1, 12), st.integers(1, 12), st.integers(1, 60)),
    sigma=st.floats(0.1, 6),
    seed=st.integers(0, 99),
)
@settings(max_examples=25)
def test_keeps_the_total(shape, sigma, seed):
    """The mirrored border loses no light."""
    field = np.abs(random_field(shape, seed))
    total = blurred(field, sigma, "cpu").sum(dtype=np.float64)
    assert total == pytest.approx(field.sum(dtype=np.float64), rel=2e-6)


def test_sigma_zero_changes_nothing(device):
    """Not a single bit."""
    field = random_field((7, 8, 51))
    np.testing.assert_array_equal(blurred(field, 0, device), field)


def test_may_write_over_its_input(device):
    """In place, and with memory to work in, the result is the same."""
    field = random_field((11, 10, 49))
    array = wp.array(field, dtype=float, device=device)
    returned = blur(array, 1.3, scratch=wp.empty_like(array), out=array)
    assert returned is array
    np.testing.assert_array_equal(array.numpy(), blurred(field, 1.3, device))


def test_leaves_its_input_alone(device):
    """Without ``out`` the field stays as it was."""
    field = random_field((11, 10, 49))
    array = wp.array(field, dtype=float, device=device)
    blur(array, 1.3)
    np.testing.assert_array_equal(array.numpy(), field)


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    """One thread or three."""
    field = random_field((40, 33, 70))
    results = []
    for threads in ("1", "3"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        results.append(blurred(field, 1.0, "cpu"))
    np.testing.assert_array_equal(*results)


@pytest.mark.parametrize("sigma", [-1.0, (1.0, 1.0), (1.0, -1.0, 1.0)])
def test_refuses_a_senseless_sigma(sigma, device):
    """The message names it."""
    with pytest.raises(ValueError, match="sigma"):
        blurred(np.ones((4, 4, 4), np.float32), sigma, device)

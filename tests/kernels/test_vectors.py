"""Vector arithmetic against NumPy in float64."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.kernels import vectors

SHAPE = (9, 7, 53)


@pytest.fixture
def fields():
    """Three positive volumes."""
    return [np.random.default_rng(seed).uniform(0.1, 2, SHAPE).astype(np.float32) for seed in range(3)]


def on(device, field):
    return wp.array(field, dtype=float, device=device)


@given(
    shape=st.tuples(st.integers(1, 20), st.integers(1, 9), st.integers(1, 110)),
    seed=st.integers(0, 99),
    weighted=st.booleans(),
)
@settings(max_examples=25)
def test_dot_sums_in_float64(device, shape, seed, weighted):
    """Far better than float32 sums, for any shape, with and without a factor a row."""
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((2, *shape)).astype(np.float32)
    weights = rng.uniform(0, 9, shape[0]) if weighted else np.ones(shape[0])
    products = weights[:, None, None] * a.astype(np.float64) * b.astype(np.float64)
    found = vectors.dot(on(device, a), on(device, b), weights=list(weights) if weighted else None)
    assert found == pytest.approx(products.sum(), abs=1e-13 * np.abs(products).sum())


def test_dot_gives_the_same_bits_for_any_number_of_threads(monkeypatch):
    """The order of the sum does not depend on who adds."""
    a, b = (on("cpu", x) for x in np.random.default_rng(3).standard_normal((2, 50, 40, 60)).astype(np.float32))
    results = set()
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("WARPFLUID_THREADS", threads)
        results |= {vectors.dot(a, b) for _ in range(3)}
    assert len(results) == 1


def test_add_scaled(fields, device):
    """a + factor b, also over either input."""
    a, b, _ = fields
    expected = a + np.float32(-0.75) * b
    x, y = on(device, a), on(device, b)
    np.testing.assert_allclose(vectors.add_scaled(x, -0.75, y, out=wp.empty_like(x)).numpy(), expected, atol=3e-7)
    np.testing.assert_allclose(vectors.add_scaled(x, -0.75, y, out=y).numpy(), expected, atol=3e-7)
    np.testing.assert_allclose(vectors.add_scaled(x, -0.75, on(device, b), out=x).numpy(), expected, atol=3e-7)


def test_multiply(fields, device):
    """The product is NumPy's, bit by bit."""
    a, b, _ = fields
    x = on(device, a)
    np.testing.assert_array_equal(vectors.multiply(x, on(device, b), out=x).numpy(), a * b)


def test_sharpen(fields, device):
    """What two blurred copies leave, inside the mask alone."""
    a, b, c = fields
    mask = (np.arange(a.size).reshape(a.shape) % 3 > 0).astype(np.float32)
    arrays = [on(device, x) for x in (a, b, c, mask)]
    found = vectors.sharpen(
        *arrays[:3], fine_weight=0.6, coarse_weight=0.35, mask=arrays[3], out=wp.empty_like(arrays[0])
    )
    np.testing.assert_allclose(found.numpy(), mask * (a - 0.6 * b - 0.35 * c), atol=5e-7)


def test_clip(device):
    """Negative values become 0, others stay."""
    field = np.random.default_rng(0).standard_normal(SHAPE).astype(np.float32)
    np.testing.assert_array_equal(vectors.clip(on(device, field)).numpy(), np.maximum(field, 0))
    np.testing.assert_array_equal(vectors.clip(on(device, field), 0.5).numpy(), np.maximum(field, np.float32(0.5)))


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_ratio(fields, power, device):
    """Target over rendering, capped; where the rendering is dark the factor is 1."""
    target, rendered, _ = fields
    rendered = np.where(rendered < 0.4, 0.001 * rendered, rendered).astype(np.float32)
    found = vectors.ratio(
        on(device, target), on(device, rendered), floor=0.01, cap=3.0, power=power, out=on(device, rendered)
    )
    expected = np.where(rendered > 0.01, np.minimum(target / rendered, 3.0) ** power, 1.0)
    np.testing.assert_allclose(found.numpy(), expected, rtol=2e-6)


def test_means_over_rays(fields, device):
    """``apply_mean`` multiplies by total / seen, ``divide`` divides; nothing seen is no division by zero."""
    field, total, seen = fields
    arrays = [on(device, x) for x in fields]
    np.testing.assert_allclose(vectors.apply_mean(*arrays).numpy(), field * total / seen, rtol=1e-6)
    assert np.isfinite(vectors.apply_mean(*arrays[:2], wp.zeros_like(arrays[2])).numpy()).all()
    black = on(device, total)
    found = vectors.divide(black, arrays[2], floor=0.25, out=black).numpy()
    np.testing.assert_allclose(found, total / (seen + 0.25), rtol=1e-6)


def test_fade(fields, device):
    """Linear from 1 where nothing is black to 0 at the limit, and 0 beyond."""
    field, share, cover = fields
    arrays = [on(device, x) for x in fields]
    expected = field * np.clip(1 - share / cover / 0.5, 0, 1)
    np.testing.assert_allclose(vectors.fade(*arrays, limit=0.5).numpy(), expected, atol=2e-6)


@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 5, 7), (20, 30, 100)])
def test_largest(shape, device):
    """Of both signs, wherever it is; NaN is larger than all."""
    values = np.random.default_rng(0).standard_normal(shape).astype(np.float32)
    for found in (np.abs(values).max(), np.float32(9.0), np.float32(np.inf)):
        values.flat[-1] = -found
        assert vectors.largest(wp.array(values, device=device)) == found
    values.flat[values.size // 2] = np.nan
    assert np.isnan(vectors.largest(wp.array(values, device=device)))


def test_inverse_root(device):
    """And 0 where there is nothing to take it of."""
    found = vectors.inverse_root(wp.array(np.float32([4, 0, -1, 0.25]), device=device), out=wp.zeros(4, device=device))
    np.testing.assert_allclose(found.numpy(), [0.5, 0, 0, 2])


def test_large_arrays_are_handled_whole(device):
    """They are cut into ranges for threads, the last one shorter."""
    a = np.arange(600_001, dtype=np.float32)
    field = wp.array(a, dtype=float, device=device)
    out = wp.zeros_like(field)
    np.testing.assert_array_equal(vectors.add_scaled(field, 2.0, field, out=out).numpy(), 3 * a)
    np.testing.assert_array_equal(vectors.add_scaled(field, -1.0, field, out=field).numpy(), 0 * a)

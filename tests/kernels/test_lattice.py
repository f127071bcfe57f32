"""Lattices joined by splines, against SciPy's."""

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from warpfluid.kernels.forces.lattice import CLOSEST, interpolate


@given(
    nodes=st.tuples(*[st.integers(1, 20)] * 3),
    shape=st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(1, 110)),
    spacing=st.tuples(*[st.floats(CLOSEST, 30)] * 3),
    first=st.tuples(*[st.floats(-60, 60)] * 3),
)
@settings(max_examples=40)
def test_interpolates_as_scipy_does(nodes, shape, spacing, first):
    """Periodic cubic B-splines, however often the lattice repeats; added to what is there."""
    rng = np.random.default_rng(0)
    tile, start = rng.standard_normal(nodes).astype(np.float32), rng.standard_normal(shape).astype(np.float32)
    out = wp.array(start, dtype=float, device="cpu")
    interpolate(wp.array(tile, dtype=float, device="cpu"), first=first, spacing=spacing, gain=0.7, out=out)
    places = [np.arange(n) / s + f for n, s, f in zip(shape, spacing, first, strict=True)]
    grid = [g % n for g, n in zip(np.meshgrid(*places, indexing="ij"), nodes, strict=True)]
    expected = map_coordinates(tile.astype(float), grid, order=3, mode="grid-wrap", prefilter=False)
    np.testing.assert_allclose(out.numpy(), start + 0.7 * expected, atol=2e-4)


def test_interpolates_on_every_device(device):
    """Long columns, the closest nodes, a lattice that repeats."""
    tile = np.random.default_rng(0).standard_normal((6, 7, 9)).astype(np.float32)
    out = wp.zeros((5, 6, 107), dtype=float, device=device)
    interpolate(wp.array(tile, device=device), first=(0.5, -2.2, -3), spacing=(CLOSEST,) * 3, gain=1.0, out=out)
    places = [np.arange(n) / CLOSEST + f for n, f in zip(out.shape, (0.5, -2.2, -3), strict=True)]
    grid = [g % n for g, n in zip(np.meshgrid(*places, indexing="ij"), tile.shape, strict=True)]
    expected = map_coordinates(tile.astype(float), grid, order=3, mode="grid-wrap", prefilter=False)
    np.testing.assert_allclose(out.numpy(), expected, atol=1e-4)


def test_refuses_nodes_that_lie_too_close(device):
    """A run of heights has room for so many."""
    tile = wp.zeros((9, 9, 9), dtype=float, device=device)
    with pytest.raises(ValueError, match="spacing"):
        interpolate(tile, first=(0, 0, 0), spacing=(1, 1, 0.5), gain=1.0, out=wp.zeros_like(tile))

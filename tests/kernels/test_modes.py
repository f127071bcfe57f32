"""Changes of basis against NumPy, in arrays with NaN all around them; and that who adds up does not matter."""

import numpy as np
import pytest
from test_pressure_kernels import SHAPES, Guarded

from warpfluid.kernels import launch
from warpfluid.kernels.poisson.modes import change_basis, invert_laplacian


@pytest.mark.parametrize("shape", [*SHAPES, (9, 7, 97)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_is_a_matrix_product(shape, axis, device):
    """The columns of the matrix are the modes, its transpose leads back."""
    rng, guarded = np.random.default_rng(axis), Guarded(device)
    field = rng.standard_normal(shape)
    modes, _ = np.linalg.qr(rng.standard_normal((shape[axis],) * 2))
    found = guarded(np.zeros(shape))
    change_basis(guarded(field), guarded(modes), axis=axis, out=found)
    wanted = np.moveaxis(np.tensordot(modes, field, (0, axis)), 0, axis)
    np.testing.assert_allclose(found.numpy(), wanted, atol=3e-6)
    back = guarded(np.zeros(shape))
    change_basis(found, guarded(modes.T), axis=axis, out=back)
    np.testing.assert_allclose(back.numpy(), field, atol=5e-6)
    guarded.check()


def test_divides_by_the_sum_of_eigenvalues(device):
    """And drops what has none."""
    rng, guarded = np.random.default_rng(0), Guarded(device)
    field, values = rng.standard_normal((3, 2, 50)), [np.arange(n) for n in (3, 2, 50)]
    out = guarded(field)
    invert_laplacian(*(guarded(value) for value in values), out=out)
    total = values[0][:, None, None] + values[1][:, None] + values[2]
    np.testing.assert_allclose(out.numpy(), np.where(total > 0, -field / np.maximum(total, 1), 0), atol=1e-6)
    guarded.check()


def test_an_axis_that_is_none(device):
    """Is refused."""
    guarded = Guarded(device)
    field, modes = guarded(np.zeros((2, 2, 2))), guarded(np.eye(2))
    with pytest.raises(ValueError, match="axis is 3"):
        change_basis(field, modes, axis=3, out=guarded(np.zeros((2, 2, 2))))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_ranges_do_not_matter(axis, monkeypatch):
    """Any cut of a launch gives the same bits."""
    rng, guarded, found = np.random.default_rng(0), Guarded("cpu"), set()
    shape = (37, 23, 61)
    field, modes = guarded(rng.standard_normal(shape)), guarded(rng.standard_normal((shape[axis],) * 2))
    for rows in (1, 3, 16, 100):
        monkeypatch.setattr(launch, "_ROWS_A_JOB", rows)
        found.add(change_basis(field, modes, axis=axis, out=guarded(np.zeros(shape))).numpy().tobytes())
    assert len(found) == 1

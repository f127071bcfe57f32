"""Volumes carried along the footage's flow."""

import numpy as np
import pytest

from warpfluid.motion.carry import carry
from warpfluid.motion.optical_flow import METHODS, optical_flow
from warpfluid.projector import Projector
from warpfluid.views import Views

N, HEIGHTS = 40, 48
ANGLES = (0.0, 90.0)


def puff(x, z, y, size=4.0):
    """A blob with some structure, shape (x, z, y)."""
    axes = np.indices((N, N, HEIGHTS)).astype(np.float32)
    at = axes - np.array([x, z, y], np.float32).reshape(3, 1, 1, 1)
    ripple = 1 + 0.4 * np.sin(at[0] * 1.1) * np.cos(at[2] * 0.9) * np.cos(at[1] * 0.8)
    return (10 * ripple * np.exp(-(at**2).sum(0) / (2 * size**2))).astype(np.float32)


def views_of(volume, device):
    return Views(Projector(ANGLES, volume.shape, device=device).project(volume), ANGLES)


@pytest.mark.parametrize("method", METHODS)
def test_flow_finds_a_shift(method):
    """A picture moved by two and one pixels, where it is lit."""
    images = puff(20, 20, 20).sum(1), puff(22, 20, 21).sum(1)
    flow = optical_flow(*images, method=method, white=float(images[0].max()))
    lit = images[0] > 0.2 * images[0].max()
    np.testing.assert_allclose(np.median(flow[:, lit], axis=1), [2, 1], atol=0.3)


def test_flow_refuses_what_it_does_not_know():
    """Names and shapes."""
    with pytest.raises(ValueError, match="nltv-ncc, ilk, tvl1"):
        optical_flow(np.zeros((9, 9)), np.zeros((9, 9)), method="psychic")
    with pytest.raises(ValueError, match=r"\(9, 8\)"):
        optical_flow(np.zeros((9, 9)), np.zeros((9, 8)))


def test_a_puff_arrives_where_the_pictures_show_it(device):
    """Motion along all three axes is found from two views; the total is kept."""
    before, after = puff(18, 22, 18), puff(20, 21, 21)
    carried = carry(before, views_of(before, device), views_of(after, device), device=device)
    assert np.corrcoef(carried.ravel(), after.ravel())[0, 1] > 0.97
    assert np.corrcoef(before.ravel(), after.ravel())[0, 1] < 0.85
    assert carried.sum() == pytest.approx(before.sum(), rel=0.05)


def test_nothing_moves_to_nothing(device):
    """An empty volume stays empty, and still pictures leave a volume in place."""
    volume = puff(20, 20, 20)
    views = views_of(volume, device)
    assert not carry(np.zeros_like(volume), views, views, device=device).any()
    np.testing.assert_allclose(carry(volume, views, views, device=device), volume, atol=0.02 * volume.max())

"""Multiplication and flame sheet: exact marginals, thin sheets, convex blends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from warpfluid.metrics import psnr
from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.couplings import blend_weights, sheet
from warpfluid.reconstruction.em import reconstruct
from warpfluid.views import Views

METHODS = ("multiplication", "flame-sheet")
PAIRS = [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (0.0, 60.0), (35.0, -52.0), (10.0, 130.0)]


def see(volume, angles_deg):
    """The views of a volume."""
    return Views(Projector(angles_deg, volume.shape, device="cpu").project(volume), angles_deg)


def make(views, method, **changes):
    return reconstruct(views, ReconstructOptions(method=method, **changes), device="cpu")


def marginals(rng, n, m, heights):
    """Rows of random light, some pixels and one height dark, with the same totals."""
    front, side = (rng.random((k, heights)) * (rng.random((k, heights)) < 0.7) for k in (n, m))
    front[0], side[-1] = 0.5, 0.25
    front[:, 1] = side[:, 1] = 0
    return front, side * np.divide(front.sum(0), side.sum(0), out=np.zeros(heights), where=side.sum(0) > 0)


@pytest.mark.parametrize(("n", "m"), [(20, 20), (7, 31), (1, 5), (1, 1)])
def test_a_sheet_has_both_marginals(n, m):
    """To float32's rounding, with at most n + m - 1 cells a slice that are not dark, and light only where both are."""
    front, side = marginals(np.random.default_rng(n), n, m, 6)
    volume = sheet(front, side)
    assert volume.shape == (n, m, 6)
    assert volume.min() >= 0
    np.testing.assert_allclose(volume.sum(axis=1, dtype=np.float64), front, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(volume.sum(axis=0, dtype=np.float64), side, rtol=1e-6, atol=1e-6)
    assert ((volume > 0).sum(axis=(0, 1)) <= n + m - 1).all()
    assert not volume[..., 1].any()


@given(arrays(np.float64, (2, 9), elements=st.sampled_from([0.0, 0.0, 1.0, 1.0, 2.0, 0.1, 1e-9, 1e6])))
def test_a_sheet_is_comonotone(rows):
    """Of two lit cells neither lies further in x and nearer in z; equal pixels and dark ones are no exception."""
    rows[:, 4] += 1
    rows[1] *= rows[0].sum() / rows[1].sum()
    volume = sheet(rows[0][:, None], rows[1][:, None])[..., 0]
    x, z = np.nonzero(volume)
    assert (np.diff(z[np.lexsort((z, x))]) >= 0).all()
    np.testing.assert_allclose(volume.sum(axis=1), rows[0], rtol=1e-5, atol=1e-6 * rows[0].sum())


def test_a_view_with_itself_makes_a_diagonal():
    """The coupling of a row with itself is the row, laid out on x = z."""
    row = np.array([0.0, 3, 1, 0, 2])
    np.testing.assert_allclose(sheet(row[:, None], row[:, None])[..., 0], np.diag(row), atol=1e-6)


def test_multiplication_has_a_closed_form(fire):
    """Front times side over the total in every slice."""
    views = see(fire, (0.0, 90.0))
    front, side = views.images.astype(np.float64)
    total = front.sum(axis=0)
    expected = front[:, None] * side[None] / np.where(total > 0, total, 1)
    found = make(views, "multiplication").volume
    # what lies farther from the silhouettes than a margin is left out of the box's part
    np.testing.assert_allclose(found, expected, atol=2e-3 * expected.max())


@pytest.mark.parametrize("angles", PAIRS)
@pytest.mark.parametrize("method", METHODS)
def test_two_views_come_back(fire, angles, method):
    """To rounding at a right angle along the axes, after balancing at any other; nowhere negative."""
    views = see(fire, angles)
    found = make(views, method)
    assert found.volume.min() >= 0
    right = angles in PAIRS[:3]
    for rendered, image in zip(found.render(angles), views.images, strict=True):
        assert psnr(rendered, image) > (90 if right else 50)


@pytest.mark.parametrize("angles", PAIRS)
def test_a_sheet_is_thin(fire, angles):
    """At most 2 n - 1 voxels a slice along the axes; four times as many where the curve does not follow the grid."""
    lit = (make(see(fire, angles), "flame-sheet").volume > 0).sum(axis=(0, 1)).max()
    n = len(fire)
    assert lit <= (2 * n - 1 if angles in PAIRS[:3] else 4 * (2 * n - 1))
    assert lit < 0.5 * (make(see(fire, angles), "multiplication").volume > 0).sum(axis=(0, 1)).max()


def test_multiplication_of_many_views_comes_back(fire):
    """Multiplicative ART reaches all of them."""
    angles = (0.0, 30.0, 60.0, 90.0, 120.0, 150.0)
    views = see(fire, angles)
    for rendered, image in zip(make(views, "multiplication").render(angles), views.images, strict=True):
        assert psnr(rendered, image) > 50


def test_many_sheets_blend(fire):
    """A mixture is nearer to three views than the sheet of any pair, and as bright as they are."""
    angles = (0.0, 45.0, 90.0)
    views = see(fire, angles)
    error = lambda volume: np.square(see(volume, angles).images - views.images, dtype=np.float64).sum()  # noqa: E731
    blend = make(views, "flame-sheet").volume
    assert blend.min() >= 0
    assert blend.sum(dtype=np.float64) == pytest.approx(fire.sum(dtype=np.float64), rel=1e-3)
    for pair in ((0, 1), (0, 2), (1, 2)):
        part = Views(views.images[list(pair)], tuple(angles[i] for i in pair))
        assert error(blend) < error(make(part, "flame-sheet").volume)


def test_blend_weights():
    """Convex weights are found again, and one column alone weighs 1."""
    rng = np.random.default_rng(4)
    columns = rng.random((50, 5))
    weights = np.array([0.5, 0, 0.2, 0.3, 0])
    np.testing.assert_allclose(blend_weights(columns, columns @ weights), weights, atol=1e-3)
    np.testing.assert_allclose(blend_weights(columns[:, :1], rng.random(50)), [1])
    np.testing.assert_allclose(blend_weights(np.zeros((50, 4)), rng.random(50)), 0.25)  # nothing to choose from


@pytest.mark.parametrize("stand_in", ["mirror", "front", "measured"])
@pytest.mark.parametrize("method", METHODS)
def test_one_view_and_its_stand_in(fire, method, stand_in):
    """The front is exact; given twice it makes a volume that is symmetric in x and z."""
    views = see(fire, (0.0,))
    found = make(views, method, stand_in=stand_in)
    assert psnr(found.render([0.0])[0], views.images[0]) > 70
    if stand_in == "measured":
        np.testing.assert_array_equal(found.volume, found.volume.transpose(1, 0, 2))

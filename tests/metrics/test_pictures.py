"""The metrics: zero on a copy, SciPy's numbers, and no adversary fools the independent ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.stats import wasserstein_distance

from warpfluid.metrics import METRICS, appearance_distance, compare_pictures, grid_index, pictures, ssim
from warpfluid.metrics.spectra import analytic_bands

INDEPENDENT = [m.name for m in METRICS.values() if m.group == "independent" and m.best == "low"]


def plume(seed=0, size=48, height=64):
    """A flame-like volume (x, z, y): stretched noise, cut into wisps inside a cone."""
    rng = np.random.default_rng(seed)
    noise = sum(
        weight * ndimage.gaussian_filter(rng.standard_normal((size, size, height)), (g, g, 2 * g)) * g**2
        for g, weight in ((1, 1), (2, 1.2), (4, 1.5))
    )
    x = np.arange(size) - (size - 1) / 2
    radius = np.hypot(x[:, None], x)[..., None] / (size * 0.42 * np.linspace(1, 0.5, height))
    return np.maximum(noise - 1.2 * radius**2, 0).astype(np.float32)


def look(volume, angle):
    """A picture (rows, columns) of a volume at an angle, by rotating the volume."""
    turned = ndimage.rotate(volume, -angle, axes=(0, 1), reshape=False, order=1)
    return turned.sum(axis=1).T[::-1]


@pytest.fixture(scope="module")
def views():
    """Pictures of one plume by angle, brightest pixel of the front at 255."""
    volume = plume()
    scale = 255 / look(volume, 0).max()
    return {angle: look(volume * scale, angle) for angle in (0, 35, 45, 55, 90)}


def with_values_of(candidate, truth):
    """The candidate with exactly the truth's grey values."""
    out = np.empty(truth.size)
    out[np.argsort(candidate, axis=None, kind="stable")] = np.sort(truth, axis=None)
    return out.reshape(truth.shape)


def adversary(kind, truth):
    """A picture that fools the tuned metrics."""
    blurred = ndimage.gaussian_filter(truth, 2.5)
    if kind == "blurred":
        return blurred
    if kind == "sharpened":
        return with_values_of(blurred + 4 * (blurred - ndimage.gaussian_filter(blurred, 2)), truth)
    phase = np.angle(np.fft.fft2(np.random.default_rng(1).standard_normal(truth.shape)))
    return with_values_of(np.fft.ifft2(np.abs(np.fft.fft2(truth)) * np.exp(1j * phase)).real, truth)


def test_a_copy_is_perfect(views):
    """Distances of a copy are zero and ratios one."""
    for name, value in compare_pictures(views[45], views[45]).items():
        wanted = {"psnr": pytest.approx(228.13, abs=0.01), "ssim": 1}
        assert value == wanted.get(name, {"low": 0, "one": 1}.get(METRICS[name].best)), name


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10), st.floats(-5, 5))
def test_wasserstein_is_scipys(seed, scale, shift):
    """W1 is SciPy's Wasserstein distance over the truth's deviation."""
    rng = np.random.default_rng(seed)
    a, b = rng.normal(shift, scale, (9, 7)), rng.gamma(2, 1, (9, 7))
    assert pictures.wasserstein(a, b) == pytest.approx(wasserstein_distance(a.ravel(), b.ravel()) / b.std())


def test_bands_are_those_of_real_filters(views):
    """The sub-bands are what real third-order filters give at full size, seen every second pixel a scale."""
    picture = views[0]
    wy, wx = np.meshgrid(*(2 * np.pi * np.fft.fftfreq(n) for n in picture.shape), indexing="ij")
    radius, direction = np.maximum(np.hypot(wy, wx), 1e-12), np.arctan2(wy, wx)
    bands = list(analytic_bands(picture, scales=3, decimate=True))
    for scale in range(3):
        low = np.cos(np.pi / 2 * np.clip(np.log2(radius / np.pi * 2**scale) + 1, 0, 1))
        high = np.sin(np.pi / 2 * np.clip(np.log2(radius / np.pi * 2**scale) + 2, 0, 1))
        for orientation in range(4):
            angular = np.cos(direction - orientation * np.pi / 4) ** 3
            full = np.fft.ifft2(np.fft.fft2(picture) * low * high * angular)
            assert np.abs(full.real).max() < 1e-6
            thinned = full.imag[:: 2**scale, :: 2**scale]
            found = 2 * bands[4 * scale + orientation].imag / 4**scale
            np.testing.assert_allclose(found, thinned, atol=1e-7 * np.abs(full).max())


@pytest.mark.parametrize("kind", ["blurred", "sharpened", "scrambled"])
def test_adversaries_lose_to_a_true_neighbour(views, kind):
    """Blurred, sharpened and phase-scrambled copies rank behind a true view from nearby."""
    floor = compare_pictures(views[35], views[45])
    found = compare_pictures(adversary(kind, views[45]), views[45])
    worse = [name for name in INDEPENDENT if found[name] > floor[name]]
    assert len(worse) >= len(INDEPENDENT) - 1, {n: (found[n], floor[n]) for n in INDEPENDENT}
    if kind != "blurred":
        assert found["intensity_w1"] == 0, "the histogram alone is fooled"


def test_ratios_tell_the_direction_of_detail(views):
    """Blur across lowers the gradient ratio and raises the streak; blur down lowers the streak."""
    truth = views[45]
    across = compare_pictures(ndimage.gaussian_filter1d(truth, 1.5, axis=1), truth)
    down = compare_pictures(ndimage.gaussian_filter1d(truth, 1.5, axis=0), truth)
    assert across["gradient_ratio"] < 0.85
    assert across["streak"] > 1.1
    assert down["streak"] < 0.9


def test_physical_metrics_by_hand():
    """Row mass, silhouette, perimeter and PSNR of two squares, counted by hand."""
    truth, moved = np.zeros((30, 30)), np.zeros((30, 30))
    truth[10:20, 10:20], moved[10:20, 15:25] = 100, 100
    assert pictures.row_mass(moved, truth) == 0
    assert pictures.row_mass(2 * moved, truth) == 1
    assert pictures.silhouette(moved, truth) == pytest.approx(1 - 50 / 150)
    truth[10, 10] = 200  # the quantiles of a single grey level would lie on it
    moved[moved > 0] = 99
    assert pictures.perimeter(moved, truth) == pytest.approx(1)
    assert pictures.psnr(truth + 25.5, truth) == pytest.approx(20)


def test_distance_without_truth_is_the_mean_over_the_footage(views):
    """Without truth the metrics that need the same angle drop out and the rest is averaged."""
    found = appearance_distance(views[45], [views[0], views[90]])
    unmeasured = {name for name, metric in METRICS.items() if metric.measure is None}
    assert set(METRICS) - set(found) == {"silhouette", "psnr", "ssim", *unmeasured}
    each = [compare_pictures(views[45], views[angle]) for angle in (0, 90)]
    for name, value in found.items():
        assert value == pytest.approx((each[0][name] + each[1][name]) / 2)
    grey = appearance_distance(adversary("blurred", views[45]), [views[0], views[90]])
    assert grey["patch_swd"] > 1.3 * found["patch_swd"]


def test_grid_index_sees_woven_slices():
    """A volume made of smeared views is woven along them, the plume is not, and turned inputs are found."""
    volume = plume(size=40, height=24)
    woven = volume.sum(axis=0, keepdims=True) + volume.sum(axis=1, keepdims=True)
    assert 0.5 < grid_index(volume) < 1.6
    assert grid_index(woven) > 3
    turned = ndimage.rotate(woven, 45, axes=(0, 1), reshape=False, order=1)
    assert grid_index(turned, angles_deg=(45, 135)) > 3 > grid_index(turned)


@pytest.mark.parametrize(
    ("candidate", "truth", "words"),
    [
        (np.ones((30, 30)), np.ones((30, 31)), "(30, 30) and (30, 31)"),
        (np.ones((30, 30, 3)), np.ones((30, 30, 3)), "grey pictures"),
        (np.ones((20, 30)), np.ones((20, 30)), "at least 25"),
        (np.full((30, 30), np.nan), np.ones((30, 30)), "candidate holds"),
        (np.ones((30, 30)), np.zeros((30, 30)), "leave this frame out"),
    ],
)
def test_what_cannot_be_measured_is_refused(candidate, truth, words):
    """Wrong sizes, broken values and black truths are named."""
    with pytest.raises(ValueError, match=words.replace("(", r"\(").replace(")", r"\)")):
        compare_pictures(candidate, truth)


def test_a_black_candidate_has_numbers(views):
    """A candidate that went black is measured, with finite numbers."""
    assert np.isfinite(list(compare_pictures(np.zeros_like(views[0]), views[0]).values())).all()


def test_missing_references_and_empty_volumes_are_refused():
    """An empty list, a flat array and an empty volume are named."""
    with pytest.raises(ValueError, match="references is empty"):
        appearance_distance(np.ones((30, 30)), [])
    with pytest.raises(ValueError, match=r"shape \(30, 30\)"):
        grid_index(np.ones((30, 30)))
    with pytest.raises(ValueError, match="no structure"):
        grid_index(np.zeros((12, 12, 4)))


def test_structural_similarity(views):
    """One for a copy, less the more a copy is blurred."""
    blurs = [ndimage.gaussian_filter(views[0], sigma) for sigma in (0, 1, 3)]
    found = [ssim(blurred, views[0]) for blurred in blurs]
    assert found[0] == 1
    assert found[0] > found[1] > found[2]

"""Portilla and Simoncelli's statistics: measured as NumPy and pyrtools do, and set by a few sweeps."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from warpfluid.options import ReconstructOptions
from warpfluid.projector import Projector
from warpfluid.reconstruction.analytic_pyramid import AnalyticPyramid
from warpfluid.reconstruction.em import reconstruct
from warpfluid.reconstruction.joint_statistics import measure, mix, rows
from warpfluid.reconstruction.portilla_simoncelli import PortillaSimoncelli, adjust
from warpfluid.views import Views

ANGLES = (0.0, 90.0)
SIZE = (48, 40)


@pytest.fixture(scope="module")
def inputs(fire):
    """Front and side."""
    return Projector(ANGLES, fire.shape, device="cpu").project(fire)


@pytest.fixture(scope="module")
def pyramid():
    """Two scales in double precision."""
    return AnalyticPyramid(SIZE, 2, dtype=np.float64)


def farthest(found, wanted):
    """How far statistics are from others: of each kind the largest difference over the largest value."""
    return {key: np.abs(found[key] - wanted[key]).max() / np.abs(wanted[key]).max() for key in wanted}


def test_statistics_are_those_of_plain_numpy(inputs, pyramid):
    """Every kind from sums over pixels and shifts."""
    image = inputs[1].astype(np.float64)
    found, levels = rows(measure(pyramid, inputs), 1), pyramid.analyze(image)
    apart = image - image.mean()
    moments = [image.mean(), image.var(), (apart**3).mean() / image.std() ** 3, (apart**4).mean() / image.var() ** 2]
    np.testing.assert_allclose(found["pixel", 0], [*moments, image.min(), image.max()], rtol=1e-6)
    assert found["highpass", 0] == pytest.approx(levels.highpass.var(), rel=1e-6)

    low = levels.lows[1] - levels.lows[1].mean()
    for a in (-3, 0, 2):
        for b in (-1, 0, 3):
            shifted = (low * np.roll(low, (a, b), (0, 1))).mean()
            assert found["low autocorrelation", 1][a + 3, b + 3] == pytest.approx(shifted, rel=1e-6)
            strength = np.abs(levels.bands[0][2])
            strength = strength - strength.mean()
            shifted = (strength * np.roll(strength, (a, b), (0, 1))).mean()
            assert found["magnitude autocorrelation", 0][2, a + 3, b + 3] == pytest.approx(shifted, rel=1e-6, abs=1e-6)

    flat = np.abs(levels.bands[0]).reshape(4, -1)
    np.testing.assert_allclose(found["magnitude", 0], np.cov(flat, bias=True), rtol=1e-6)
    np.testing.assert_allclose(found["magnitude mean", 0], flat.mean(axis=1), rtol=1e-6)
    reals = levels.bands[0].real.reshape(4, -1)
    np.testing.assert_allclose(found["real", 0], reals @ reals.T / image.size, rtol=1e-5, atol=1e-9)


def test_parents_are_compared_at_double_phase(inputs, pyramid):
    """The coarser bands, widened by zeros in frequency, their phase doubled."""
    found = rows(measure(pyramid, inputs), 0)
    fine, coarse = pyramid.analyze(inputs[0]).bands
    spectrum = np.fft.fftshift(np.fft.fft2(coarse), axes=(1, 2))
    wide = np.zeros((4, *SIZE), complex)
    wide[:, 12:36, 10:30] = spectrum
    wide = np.fft.ifft2(np.fft.ifftshift(wide, axes=(1, 2))) * 2  # widening keeps the energy
    doubled = wide**2 / np.abs(wide)
    parts = np.concatenate([doubled.real, doubled.imag])
    parts -= parts.mean(axis=(1, 2), keepdims=True)
    wanted = np.einsum("apq,bpq->ab", fine.real, parts) / np.prod(SIZE)
    np.testing.assert_allclose(found["real parent", 0], wanted, rtol=1e-4, atol=1e-5 * np.abs(wanted).max())
    strengths = np.abs(fine), np.abs(wide)
    a, b = (s - s.mean(axis=(1, 2), keepdims=True) for s in strengths)
    wanted = np.einsum("apq,bpq->ab", a, b) / np.prod(SIZE)
    np.testing.assert_allclose(found["magnitude parent", 0], wanted, rtol=1e-4, atol=1e-5 * np.abs(wanted).max())


def test_complex_bands_are_those_of_pyrtools():
    """Magnitudes of a widely used implementation; its bands grow by 2 a scale where ours keep the light."""
    pyrtools = pytest.importorskip("pyrtools")
    image = gaussian_filter(np.random.default_rng(3).standard_normal((64, 64)), 1)
    theirs = pyrtools.pyramids.SteerablePyramidFreq(image, height=3, order=3, is_complex=True)
    ours = AnalyticPyramid((64, 64), 3, dtype=np.float64).analyze(image)
    for scale, bands in enumerate(ours.bands):
        known = [np.abs(theirs.pyr_coeffs[scale, band]) for band in range(4)]
        for band in np.abs(bands):
            likeness = [np.corrcoef(band.ravel(), other.ravel())[0, 1] for other in known]
            at = int(np.argmax(likeness))
            assert likeness[at] > 0.9999
            ratio = np.sqrt(np.square(known[at]).sum() / np.square(band).sum())
            assert ratio == pytest.approx(2**scale, rel=1e-4)


@pytest.mark.parametrize("shape", [(48, 40), (45, 51), (33, 64)])
def test_the_analytic_pyramid_is_exact(shape):
    """Scale by scale, odd sizes too; both parts of a band hold the same light; a real band tells its imaginary part."""
    pyramid = AnalyticPyramid(shape, 3, dtype=np.float64)
    images = np.random.default_rng(0).random((2, *shape))
    levels = pyramid.analyze(images)
    low = levels.lows[-1]
    for scale in reversed(range(3)):
        bands = levels.bands[scale]
        low = pyramid.merge(low, bands.real, scale)
        np.testing.assert_allclose(low, levels.lows[scale], atol=1e-12)
        np.testing.assert_allclose(pyramid.analytic(bands.real, scale), bands, atol=1e-12)
        assert np.square(bands.imag).sum() == pytest.approx(np.square(bands.real).sum())
    np.testing.assert_allclose(pyramid.finish(low, levels.highpass), images, atol=1e-12)


def test_the_phase_of_a_line_differs_from_that_of_an_edge():
    """By a quarter turn, at the same magnitude wherever the wave is."""
    pyramid = AnalyticPyramid((64, 64), 2, dtype=np.float64)
    column = 2 * np.pi * 12 * np.arange(64) / 64
    even, odd = (pyramid.analyze(np.tile(wave(column), (64, 1))).bands[0][0] for wave in (np.cos, np.sin))
    np.testing.assert_allclose(np.abs(even), np.abs(even).mean(), rtol=1e-10)
    np.testing.assert_allclose(np.abs(np.angle(even / odd)), np.pi / 2, rtol=1e-10)


def test_an_image_keeps_its_own_statistics(inputs, pyramid):
    """A projection onto what holds already changes nothing."""
    np.testing.assert_allclose(adjust(pyramid, inputs, measure(pyramid, inputs)), inputs, atol=1e-3 * inputs.max())


def test_sweeps_set_the_statistics(inputs, pyramid):
    """A blurred picture gets all of the inputs' statistics to a few percent, nearer with every sweep."""
    wanted, image = measure(pyramid, inputs), gaussian_filter(inputs, (0, 2, 2))
    before, first = farthest(measure(pyramid, image), wanted), None
    for sweep in range(12):
        image = adjust(pyramid, image, wanted)
        if sweep == 1:
            first = farthest(measure(pyramid, image), wanted)
    last = farthest(measure(pyramid, image), wanted)
    assert max(before.values()) > 0.9
    assert max(last.values()) < 0.1
    assert np.mean(list(last.values())) < 0.02
    assert sum(last.values()) < 0.35 * sum(first.values())


def test_targets_lie_between_the_inputs(inputs):
    """At an input its own, half-way the mean, mirrored beyond the last one."""
    found = PortillaSimoncelli(inputs, ANGLES, (0.0, 45.0, 90.0, 135.0), height=2)
    pyramid = found.pyramid
    padded = np.zeros((3, *pyramid.shape), np.float32)
    padded[:, : SIZE[0], : SIZE[1]] = [inputs[0], inputs[1], inputs[0, ::-1]]
    own = measure(pyramid, padded)
    for at, pair in ((0, (0, 0)), (1, (0, 1)), (2, (1, 1)), (3, (1, 2))):
        for key, values in own.items():
            mean = 0.5 * (values[pair[0]] + values[pair[1]])
            np.testing.assert_allclose(found.targets[key][at], mean, rtol=1e-5, atol=1e-6 * np.abs(values).max())


def test_mixing_is_linear():
    """Row by row."""
    first, second = {("a", 0): np.zeros((2, 3))}, {("a", 0): np.ones((2, 3))}
    np.testing.assert_allclose(mix(first, second, np.array([0.25, 1]))["a", 0], [[0.25] * 3, [1] * 3])


def test_a_view_gets_the_look_of_the_inputs(inputs):
    """An input is left alone, a blurred one gets its detail and its grey values, the outside of the mask is black."""
    transfer = PortillaSimoncelli(inputs, ANGLES, ANGLES, sweeps=3)
    mask = np.ones(inputs.shape, bool)
    np.testing.assert_allclose(transfer.transfer(inputs, mask), inputs, atol=0.25)
    blurred = gaussian_filter(inputs, (0, 2, 2))
    mask[:, :6] = False
    made = transfer.transfer(blurred, mask)
    assert not made[~mask].any()
    np.testing.assert_allclose(np.sort(made, axis=None), np.sort(inputs, axis=None), atol=8)

    def detail(images):
        return np.square(np.diff(images, axis=1)).mean()

    assert detail(blurred) < 0.6 * detail(inputs)
    assert detail(made) == pytest.approx(detail(inputs), rel=0.15)


def test_threads_do_not_matter(inputs, monkeypatch):
    """One thread and three give the same bits."""
    fan = tuple(float(angle) for angle in range(0, 180, 20))
    rendered = np.stack([gaussian_filter(inputs[i % 2], 1 + i / 4) for i in range(len(fan))])
    made = []
    for threads in (1, 3):
        monkeypatch.setenv("WARPFLUID_THREADS", str(threads))
        made.append(PortillaSimoncelli(inputs, ANGLES, fan).transfer(rendered, np.ones(rendered.shape, bool)))
    np.testing.assert_array_equal(*made)


def test_black_and_flat_views_stay_finite(inputs):
    """Nothing is divided by the spread that they lack."""
    rendered = np.stack([np.zeros(SIZE), np.full(SIZE, 7.0)]).astype(np.float32)
    assert np.isfinite(
        PortillaSimoncelli(inputs, ANGLES, ANGLES).transfer(rendered, np.ones(rendered.shape, bool))
    ).all()
    black = np.zeros_like(inputs)
    assert np.isfinite(PortillaSimoncelli(black, ANGLES, ANGLES).transfer(inputs, np.ones(inputs.shape, bool))).all()


def test_the_energy_falls(inputs, fire):
    """The iteration converges with these statistics, too, and a seed gives the same volume."""
    options = ReconstructOptions(transfer="portilla-simoncelli", iterations=5, angles=40)
    first, again = (reconstruct(Views(inputs, ANGLES), options, device="cpu") for _ in range(2))
    assert first.energies[-1, -1] < 0.6 * first.energies[0, 0]
    np.testing.assert_array_equal(first.volume, again.volume)
    assert first.volume.sum(dtype=np.float64) == pytest.approx(fire.sum(dtype=np.float64), rel=0.02)

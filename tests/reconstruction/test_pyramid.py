"""The steerable pyramid: exact and tight for every size, and the bands that others compute."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warpfluid.reconstruction.pyramid import SteerablePyramid, default_height, padded_shape

SHAPES = [(144, 271), (145, 271), (101, 77), (97, 128), (64, 64)]


def picture(shape, seed=0):
    return np.random.default_rng(seed).random(shape)


def energy(bands):
    return sum(np.square(band, dtype=np.float64).sum() for band in bands.values())


@pytest.mark.parametrize("decimate", [True, False])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
@pytest.mark.parametrize("shape", SHAPES)
def test_is_exact_and_keeps_the_energy(shape, dtype, tolerance, decimate):
    """Collapse inverts build, and the squares add up to those of the pixels: odd and prime sizes, too."""
    pyramid = SteerablePyramid(shape, 4, dtype=dtype, decimate=decimate)
    image = picture(shape)
    bands = pyramid.build(image)
    assert set(bands) == set(pyramid.keys)
    assert all(band.dtype == dtype for band in bands.values())
    assert np.abs(pyramid.collapse(bands) - image).max() < tolerance
    assert energy(bands) == pytest.approx(np.square(image).sum(), rel=tolerance)


@given(
    shape=st.tuples(st.integers(2, 70), st.integers(2, 70)),
    height=st.integers(1, 5),
    order=st.integers(0, 5),
    decimate=st.booleans(),
    seed=st.integers(0, 99),
)
@settings(max_examples=80)
def test_is_exact_for_any_shape_height_and_order(shape, height, order, decimate, seed):
    """More scales than fit and two-pixel images included."""
    pyramid = SteerablePyramid(shape, height, order, np.float64, decimate=decimate)
    image = picture(shape, seed) - 0.5
    bands = pyramid.build(image)
    assert len(bands) == height * (order + 1) + 2
    assert np.abs(pyramid.collapse(bands) - image).max() < 1e-12
    assert energy(bands) == pytest.approx(np.square(image).sum(), rel=1e-12)


@given(
    shape=st.tuples(st.integers(2, 70), st.integers(2, 70)),
    height=st.integers(1, 4),
    seed=st.integers(0, 99),
)
@settings(max_examples=40)
def test_a_parted_highpass_is_exact_too(shape, height, seed):
    """The parts put the high-pass together again, and have its energy; the other bands are the same."""
    parted = SteerablePyramid(shape, height, dtype=np.float64, part_highpass=True)
    image = picture(shape, seed) - 0.5
    bands, whole = parted.build(image), SteerablePyramid(shape, height, dtype=np.float64).build(image)
    assert list(bands) == parted.keys
    assert np.abs(parted.collapse(bands) - image).max() < 1e-12
    high = {key: band for key, band in bands.items() if key not in whole}
    assert len(high) == 3
    assert energy(high) == pytest.approx(energy({0: whole["highpass"]}), rel=1e-9, abs=1e-20)
    np.testing.assert_array_equal(bands[0, 2], whole[0, 2])


@pytest.mark.parametrize(("wave", "part"), [((0, 1), 0), ((1, 1), 1), ((1, -1), 1), ((1, 0), 2)])
def test_parts_of_the_highpass_see_what_changes_along_their_direction(wave, part):
    """Level lines are the first part's, diagonals of either kind the second's, upright lines the third's."""
    rows, columns = np.mgrid[:64, :64]
    phase = 2.8 * (wave[0] * rows + wave[1] * columns) / np.hypot(*wave)
    bands = SteerablePyramid((64, 64), 2, dtype=np.float64, part_highpass=True).build(np.sin(phase))
    energies = [energy({0: bands["highpass", i]}) for i in range(3)]
    assert int(np.argmax(energies)) == part
    assert energies[part] > 0.75 * sum(energies)


@pytest.mark.parametrize("shape", SHAPES)
def test_decimation_keeps_the_energy_of_every_band(shape):
    """A smaller band holds the same light as the full-size one."""
    image = picture(shape)
    full = SteerablePyramid(shape, 4, dtype=np.float64, decimate=False).build(image)
    small = SteerablePyramid(shape, 4, dtype=np.float64).build(image)
    for key in full:
        assert energy({key: small[key]}) == pytest.approx(energy({key: full[key]}), rel=1e-12)


def test_batches_are_built_one_by_one():
    """The leading axes are independent images; ``visit`` sees every band once."""
    pyramid = SteerablePyramid((45, 38), 3, dtype=np.float64)
    images = picture((2, 3, 45, 38))
    seen = []
    bands = pyramid.build(images, lambda key, band: seen.append(key) or band)
    assert seen == pyramid.keys
    for key, band in pyramid.build(images[1, 2]).items():
        np.testing.assert_allclose(bands[key][1, 2], band, atol=1e-14)
    np.testing.assert_allclose(pyramid.collapse(bands), images, atol=1e-12)


def reference_band(image, scale, band, order=3):
    """One full-size oriented band by the book: polar filters on a full complex spectrum.

    Raised cosines an octave wide (Simoncelli and Freeman 1995); the scale's ring is what its high-pass takes from what
    the low-passes before it left; the angular part is a power of a cosine, all bands' squares adding up to 1.
    """
    wy, wx = (2 * np.pi * np.fft.fftfreq(n) for n in image.shape)
    radius, direction = np.hypot(wy[:, None], wx), np.arctan2(wy[:, None], wx + 0 * wy[:, None])

    def low(cut):
        with np.errstate(divide="ignore"):
            octave = np.log2(radius / cut)
        return np.where(octave >= 0, 0.0, np.where(octave <= -1, 1.0, np.cos(np.pi / 2 * (np.clip(octave, -1, 0) + 1))))

    ring = low(np.pi) * np.sqrt(1 - low(np.pi / 2 ** (scale + 1)) ** 2)
    for earlier in range(1, scale + 1):
        ring = ring * low(np.pi / 2**earlier)
    count = order + 1
    strength = 2**order * math.factorial(order) / math.sqrt(count * math.factorial(2 * order))
    lobe = np.cos(direction - np.pi * band / count) ** order
    spectrum = np.fft.fft2(image) * ring * strength * 1j**order * lobe
    return np.fft.ifft2(spectrum)


@pytest.mark.parametrize("shape", [(45, 38), (33, 51), (64, 48)])
def test_bands_follow_the_formulas(shape):
    """A second implementation with full complex transforms gives the same real bands."""
    image = picture(shape)
    bands = SteerablePyramid(shape, 3, dtype=np.float64, decimate=False).build(image)
    for scale in range(3):
        for band in range(4):
            expected = reference_band(image, scale, band)
            odd = [n // 2 if n % 2 == 0 else None for n in shape]  # Nyquist has no mirror image: compare without
            difference = np.fft.fft2(bands[scale, band] - expected.real)
            for axis, nyquist in enumerate(odd):
                if nyquist is not None:
                    np.moveaxis(difference, axis, 0)[nyquist] = 0
            assert np.abs(np.fft.ifft2(difference)).max() < 1e-13


@pytest.mark.parametrize("shape", [(64, 64), (96, 128)])
def test_bands_are_those_of_pyrtools(shape):
    """Up to sign and scale, for the even sizes that pyrtools is right about; it interpolates its filters."""
    pyrtools = pytest.importorskip("pyrtools")
    image = picture(shape)
    found = SteerablePyramid(shape, 3, dtype=np.float64).build(image)
    expected = pyrtools.pyramids.SteerablePyramidFreq(image, height=3, order=3).pyr_coeffs
    names = {"residual_highpass": "highpass", "residual_lowpass": "lowpass"}
    ours = set()
    for key, theirs in expected.items():
        candidates = [names[key]] if key in names else [(key[0], band) for band in range(4)]
        match = {k: np.corrcoef(found[k].ravel(), theirs.ravel())[0, 1] for k in candidates}
        best = max(match, key=lambda k: abs(match[k]))
        assert abs(match[best]) > 1 - 1e-6
        ours.add(best)
    assert len(ours) == len(expected)


@pytest.mark.parametrize("shape", [(101, 77), (64, 96)])
def test_mirroring_swaps_the_diagonals(shape):
    """Flipping u, the first axis: bands 1 and 3 change places, band 2 changes its sign, band 0 stays."""
    image = picture(shape)
    pyramid = SteerablePyramid(shape, 4, dtype=np.float64, decimate=False)
    bands, mirrored = pyramid.build(image), pyramid.build(image[::-1])
    for scale in range(4):
        for band, (twin, sign) in enumerate([(0, 1), (3, -1), (2, -1), (1, -1)]):
            np.testing.assert_allclose(mirrored[scale, band], sign * bands[scale, twin][::-1], atol=1e-13)
    for key in ("highpass", "lowpass"):
        np.testing.assert_allclose(mirrored[key], bands[key][::-1], atol=1e-13)


@pytest.mark.parametrize("band", range(4))
def test_a_wave_excites_the_band_of_its_direction(band):
    """Band b sees what changes along b * 45 degrees, counted from the last axis to the first."""
    angle = np.deg2rad(45 * band)
    rows, columns = np.mgrid[:96, :96]
    wave = np.sin(0.8 * (columns * np.cos(angle) + rows * np.sin(angle)))
    wave *= np.outer(np.hanning(96), np.hanning(96))
    bands = SteerablePyramid((96, 96), 4, dtype=np.float64).build(wave)
    energies = [sum(energy({0: bands[scale, b]}) for scale in range(4)) for b in range(4)]
    assert int(np.argmax(energies)) == band
    assert energies[band] > 0.75 * sum(energies)


def test_an_impulse_excites_all_bands_alike():
    """No direction is preferred at coarse scales, where the corners of the spectrum play no part."""
    image = np.zeros((128, 128))
    image[64, 64] = 1
    bands = SteerablePyramid((128, 128), 4, dtype=np.float64).build(image)
    for scale in (1, 2, 3):
        energies = [energy({0: bands[scale, b]}) for b in range(4)]
        assert max(energies) < 1.01 * min(energies)


@pytest.mark.parametrize(
    ("shape", "height"), [((271, 144), 4), ((128, 300), 4), ((127, 300), 3), ((64, 64), 3), ((16, 40), 1), ((8, 8), 1)]
)
def test_default_height(shape, height):
    """Four scales from 128 pixels on, one fewer each time the shorter side halves, at least one."""
    assert default_height(shape) == height


@given(st.tuples(st.integers(8, 600), st.integers(8, 600)))
def test_padded_shape(shape):
    """Room for a margin, and no large prime factor that slows a transform."""
    for length, padded in zip(shape, padded_shape(shape), strict=True):
        assert length + 16 <= padded < 1.25 * (length + 16)
        for prime in (2, 3, 5):
            while padded % prime == 0:
                padded //= prime
        assert padded == 1


@pytest.mark.parametrize(("shape", "height", "order"), [((1, 9), 2, 3), ((9, 9), 0, 3), ((9, 9), 2, -1)])
def test_refuses_what_makes_no_pyramid(shape, height, order):
    """Sizes, heights and orders."""
    with pytest.raises(ValueError, match="expected"):
        SteerablePyramid(shape, height, order)

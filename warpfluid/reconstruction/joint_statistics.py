"""The joint statistics of a texture's complex wavelet coefficients (Portilla and Simoncelli 2000).

Beyond the histograms of single bands they say how coefficients go together: along a structure (autocorrelation),
across orientations and scales (products of magnitudes), and in phase (products of real parts with the bands of the next
coarser scale whose phase is doubled). The last two are what tells lines and edges that continue from scattered ones.
"""

import numpy as np

from warpfluid.reconstruction.analytic_pyramid import AnalyticPyramid, Levels
from warpfluid.reconstruction.moments import autocorrelation, correlations, standard_moments

REACH = 3  # of the autocorrelations: 7 x 7 shifts
TINY = 1e-6

Statistics = dict[tuple[str, int], np.ndarray]


def reach_of(size: tuple[int, int]) -> int:
    """Return the reach of the autocorrelations of an image of a size; less for small ones."""
    return max(min(REACH, min(size) // 4 - 1), 0)


def measure(pyramid: AnalyticPyramid, images: np.ndarray) -> Statistics:
    """Measure the statistics of images.

    Args:
        pyramid: That of their size.
        images: Shape (view, rows, columns).

    Returns:
        For each kind and scale (0 is the finest) an array with one row a view:

        - ``pixel``: mean, variance, skewness, kurtosis, minimum, maximum;
        - ``highpass``: variance;
        - ``low moments``, ``low autocorrelation``: skewness and kurtosis, and autocorrelation, of the low-pass image
          before each scale is split off, and of what is left after the last;
        - ``magnitude mean``, ``magnitude autocorrelation``: of each band's magnitudes;
        - ``magnitude``, ``magnitude parent``: mean products of magnitudes across orientations, and with those of the
          next coarser scale;
        - ``real``, ``real parent``: mean products of real parts across orientations, and with real and imaginary
          parts of the next coarser scale, its phase doubled.
    """
    levels = pyramid.analyze(images)
    lightest, darkest = images.max(axis=(-2, -1)), images.min(axis=(-2, -1))
    found: Statistics = {
        ("pixel", 0): np.concatenate([standard_moments(images), np.stack([darkest, lightest], -1)], axis=-1),
        ("highpass", 0): np.square(levels.highpass, dtype=np.float64).mean(axis=(-2, -1)),
    }
    for scale, low in enumerate(levels.lows):
        apart = low - low.mean(axis=(-2, -1), keepdims=True)
        found["low moments", scale] = standard_moments(apart)[..., 2:]
        found["low autocorrelation", scale] = autocorrelation(apart, reach_of(low.shape[-2:]))
    for scale, bands in enumerate(levels.bands):
        found |= _measure_bands(pyramid, levels, bands, scale)
    return found


def magnitudes(bands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the magnitudes of bands without their means, and the means, shape (..., band)."""
    strength = np.abs(bands)
    mean = strength.mean(axis=(-2, -1))
    return strength - mean[..., None, None], mean


def parents(pyramid: AnalyticPyramid, bands: np.ndarray, scale: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what a scale's bands are compared with, from the complex bands of the next coarser scale.

    Returns:
        Magnitudes, and real and imaginary parts with doubled phase: the phase of a line or an edge turns half as fast
        at the coarser scale. Both without their means, at the size of the scale.
    """
    wide = pyramid.widen(bands, scale + 1)
    strength, _ = magnitudes(wide)
    doubled = wide * wide / np.maximum(np.abs(wide), TINY)
    parts = np.concatenate([doubled.real, doubled.imag], axis=-3)
    return strength, parts - parts.mean(axis=(-2, -1), keepdims=True)


def mix(first: Statistics, second: Statistics, parts: np.ndarray) -> Statistics:
    """Interpolate statistics linearly, row by row."""

    def weight(values: np.ndarray) -> np.ndarray:
        return parts.reshape(-1, *(1,) * (values.ndim - 1))

    return {key: values + weight(values) * (second[key] - values) for key, values in first.items()}


def rows(statistics: Statistics, which) -> Statistics:
    """Return the statistics of some views."""
    return {key: values[which] for key, values in statistics.items()}


def _measure_bands(pyramid: AnalyticPyramid, levels: Levels, bands: np.ndarray, scale: int) -> Statistics:
    strength, mean = magnitudes(bands)
    found = {
        ("magnitude mean", scale): mean.astype(np.float64),
        ("magnitude autocorrelation", scale): autocorrelation(strength, reach_of(bands.shape[-2:])),
        ("magnitude", scale): correlations(strength, strength),
        ("real", scale): correlations(bands.real, bands.real),
    }
    if scale + 1 < pyramid.height:
        other, parts = parents(pyramid, levels.bands[scale + 1], scale)
        found["magnitude parent", scale] = correlations(strength, other)
        found["real parent", scale] = correlations(bands.real, parts)
    return found

"""Projections of images onto images with given moments (Portilla and Simoncelli 2000).

Each changes its images by as little as it can. Leading axes are independent.
"""

import numpy as np
import scipy.fft

RIDGE = (
    1e-3  # of the variance; neighbours in a smooth image are nearly alike, and inverting that would amplify rounding
)
GAINS = (0.2, 5.0)  # by which one projection may change a frequency
STEPS = np.linspace(-4, 4, 1601)  # along the gradient, in the steps that the gradient's size suggests
TINY = 1e-12
BINOMIAL = {2: (1, 2, 1), 3: (1, 3, 3, 1), 4: (1, 4, 6, 4, 1)}


def standard_moments(images: np.ndarray) -> np.ndarray:
    """Return mean, variance, skewness and kurtosis of images, shape (..., 4); those of a flat image are 0, 0, 0, 3."""
    mean = images.mean(axis=(-2, -1), dtype=np.float64)
    apart = images - mean[..., None, None]
    square = apart * apart
    variance = square.mean(axis=(-2, -1))
    varies = variance > TINY
    scale = np.where(varies, variance, 1)
    skewness = np.where(varies, (square * apart).mean(axis=(-2, -1)) / scale**1.5, 0)
    kurtosis = np.where(varies, (square * square).mean(axis=(-2, -1)) / scale**2, 3)
    return np.stack([mean, variance, skewness, kurtosis], axis=-1)


def correlations(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the mean products of two sets of bands, (..., n, rows, columns) and (..., m, ...), shape (..., n, m)."""
    first, second = (bands.reshape(*bands.shape[:-2], -1) for bands in (first, second))
    return (first @ second.swapaxes(-1, -2)).astype(np.float64) / first.shape[-1]


def autocorrelation(images: np.ndarray, reach: int) -> np.ndarray:
    """Return the circular autocorrelation for shifts of up to ``reach``, shape (..., 2 reach + 1, 2 reach + 1)."""
    power = np.abs(scipy.fft.rfft2(images)) ** 2
    found = scipy.fft.irfft2(power, s=images.shape[-2:]) / (images.shape[-2] * images.shape[-1])
    shifts = np.arange(-reach, reach + 1)
    return found[..., shifts[:, None], shifts].astype(np.float64)


def set_correlations(
    bands: np.ndarray, wanted: np.ndarray, beside: np.ndarray | None = None, wanted_beside: np.ndarray | None = None
) -> np.ndarray:
    """Mix bands linearly so that they have given mean products with each other, and with bands that stay.

    What is left of the bands without their regression on those beside them is mapped by the symmetric matrix that
    moves it least; the regression that is wanted is put in its place.

    Args:
        bands: Shape (..., n, rows, columns), of mean 0.
        wanted: Mean products of the result, shape (..., n, n).
        beside: Bands that stay, shape (..., m, rows, columns), of mean 0.
        wanted_beside: Mean products of the result with them, shape (..., n, m).

    Returns:
        The changed bands. Where no bands can have what is wanted, they come near.
    """
    flat = bands.reshape(*bands.shape[:-2], -1)
    found = correlations(bands, bands)
    if beside is None:
        return (_transport(found, wanted).astype(bands.dtype) @ flat).reshape(bands.shape)
    other = beside.reshape(*beside.shape[:-2], -1)
    among, across = correlations(beside, beside), correlations(bands, beside)
    among += RIDGE * np.trace(among, axis1=-2, axis2=-1)[..., None, None] / among.shape[-1] * np.eye(among.shape[-1])
    inverse = np.linalg.pinv(among, hermitian=True)
    is_now, should = across @ inverse, wanted_beside @ inverse
    rest = found - is_now @ across.swapaxes(-1, -2)
    mix = _transport(rest, wanted - should @ wanted_beside.swapaxes(-1, -2))
    out = mix.astype(bands.dtype) @ flat + (should - mix @ is_now).astype(bands.dtype) @ other
    return out.reshape(bands.shape)


def set_autocorrelation(images: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Filter images so that they have a given autocorrelation near 0, and its variance exactly.

    The filter is symmetric, its square has the wanted autocorrelation's reach, and it moves no phase.

    Args:
        images: Shape (..., rows, columns), of mean 0.
        wanted: Shape (..., 2 reach + 1, 2 reach + 1), with the shift 0 in the middle.
    """
    reach = wanted.shape[-1] // 2
    size = images.shape[-2:]
    wide = autocorrelation(images, 2 * reach)
    shifts = np.indices(wanted.shape[-2:]).reshape(2, -1)
    apart = shifts[:, :, None] - shifts[:, None, :] + 2 * reach
    matrix = wide[..., apart[0], apart[1]]
    middle = wide[..., 2 * reach, 2 * reach]
    lack = (wanted - wide[..., reach : -reach or None, reach : -reach or None]).reshape(*wanted.shape[:-2], -1)
    matrix += (RIDGE * middle + TINY)[..., None, None] * np.eye(matrix.shape[-1])
    change = np.linalg.solve(matrix, lack[..., None])[..., 0]
    spread = np.zeros((*images.shape[:-2], *size))
    spread[..., shifts[0] - reach, shifts[1] - reach] = change
    gain = np.sqrt(np.clip(1 + scipy.fft.rfft2(spread).real, GAINS[0] ** 2, GAINS[1] ** 2))
    out = scipy.fft.irfft2(scipy.fft.rfft2(images) * gain.astype(images.dtype), s=size)
    return set_variance(out, wanted[..., reach, reach])


def set_variance(images: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Scale images of mean 0; those that vary by rounding only stay."""
    found = np.square(images).mean(axis=(-2, -1), dtype=np.float64)
    factor = np.where(found > TINY, np.sqrt(np.maximum(variance, 0) / np.maximum(found, TINY)), 1)
    return images * factor[..., None, None].astype(images.dtype)


def set_skewness(images: np.ndarray, skewness: np.ndarray) -> np.ndarray:
    """Change images of mean 0 along the gradient of their skewness until it is right; mean and variance stay."""
    _, variance, found, _ = np.moveaxis(standard_moments(images), -1, 0)
    x = images / np.sqrt(np.maximum(variance, TINY))[..., None, None]
    return _along(x, x * x - 1 - found[..., None, None] * x, 3, skewness, variance).astype(images.dtype)


def set_kurtosis(images: np.ndarray, kurtosis: np.ndarray) -> np.ndarray:
    """Change images of mean 0 along the gradient of their kurtosis until it is right; mean and variance stay."""
    _, variance, skewness, found = np.moveaxis(standard_moments(images), -1, 0)
    x = images / np.sqrt(np.maximum(variance, TINY))[..., None, None]
    gradient = x * x * x - found[..., None, None] * x - skewness[..., None, None]
    return _along(x, gradient, 4, kurtosis, variance).astype(images.dtype)


def _along(x: np.ndarray, gradient: np.ndarray, order: int, wanted: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Walk from standardised images along a gradient to the nearest point with the wanted standardised moment."""
    size = np.sqrt(np.maximum(np.square(gradient).mean(axis=(-2, -1), dtype=np.float64), TINY))
    gradient = gradient / size[..., None, None]
    powers = [np.ones_like(x), x, x * x, x * x * x, x * x * x * x][: order + 1]
    slopes = [np.ones_like(x), gradient]
    while len(slopes) <= order:
        slopes.append(slopes[-1] * gradient)

    def polynomial(degree: int) -> np.ndarray:
        rows = [(powers[degree - k] * slopes[k]).mean(axis=(-2, -1), dtype=np.float64) for k in range(degree + 1)]
        return np.stack([BINOMIAL[degree][k] * row for k, row in enumerate(rows)], axis=-1)

    moment, spread = polynomial(order), polynomial(2)
    step = np.empty(wanted.shape)
    for index in np.ndindex(wanted.shape):
        step[index] = _nearest_root(moment[index], spread[index], order / 2, wanted[index])
    out = x + step[..., None, None] * gradient
    out -= out.mean(axis=(-2, -1), keepdims=True)
    return set_variance(out, np.where(variance > TINY, variance, 0))


def _nearest_root(moment: np.ndarray, spread: np.ndarray, power: float, wanted: float) -> float:
    """Return the smallest step at which moment over spread to a power is as wanted, or the one that comes nearest."""

    def lack(step):
        below = np.maximum(np.polynomial.polynomial.polyval(step, spread), TINY)
        return np.polynomial.polynomial.polyval(step, moment) / below**power - wanted

    found = lack(STEPS)
    crossing = np.flatnonzero(np.sign(found[1:]) != np.sign(found[:-1]))
    if not crossing.size:
        return float(STEPS[np.abs(found).argmin()])
    at = crossing[np.abs(STEPS[crossing] + 0.5 * (STEPS[1] - STEPS[0])).argmin()]
    low, high, sign = STEPS[at], STEPS[at + 1], np.sign(found[at])
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.sign(lack(middle)) == sign else (low, middle)
    return float(0.5 * (low + high))


def _transport(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return the symmetric matrix that gives what has one covariance another and moves it least."""
    floor = TINY + 1e-6 * np.trace(found, axis1=-2, axis2=-1)[..., None] / found.shape[-1]
    values, vectors = np.linalg.eigh(found)
    root = np.sqrt(np.maximum(values, floor))
    sides = (vectors * (1 / root)[..., None, :]) @ vectors.swapaxes(-1, -2)
    half = (vectors * root[..., None, :]) @ vectors.swapaxes(-1, -2)
    values, vectors = np.linalg.eigh(half @ wanted @ half)
    middle = (vectors * np.sqrt(np.maximum(values, 0))[..., None, :]) @ vectors.swapaxes(-1, -2)
    return sides @ middle @ sides

"""Sub-bands, local energies and power spectra of a picture."""

from collections.abc import Iterator

import numpy as np


def analytic_bands(picture: np.ndarray, scales: int, decimate: bool) -> Iterator[np.ndarray]:
    """Yield complex third-order steerable bands, four orientations a scale, fine to coarse.

    Half of the frequencies are kept: the imaginary part is the pyramid's band, the modulus its local energy.
    """
    spectrum = np.fft.fft2(picture)
    for scale in range(scales):
        # Whole frequencies of the level; indexing with them, the negative ones too, is the decimation.
        size = [-(-n // 2**scale) if decimate else n for n in picture.shape]
        ky, kx = (np.rint(np.fft.fftfreq(n) * n).astype(int) for n in size)
        wy, wx = 2 * np.pi * ky[:, None] / picture.shape[0], 2 * np.pi * kx / picture.shape[1]
        radius, direction = np.hypot(wy, wx), np.arctan2(wy, wx)
        outer, inner = (_octave(radius, np.pi / 2**s) for s in (scale, scale + 1))
        level = spectrum[np.ix_(ky, kx)] * np.cos(outer) * np.sin(inner)
        for orientation in range(4):
            yield np.fft.ifft2(level * np.maximum(np.cos(direction - orientation * np.pi / 4), 0) ** 3)


def _octave(radius: np.ndarray, cut: float) -> np.ndarray:
    """Return an angle that climbs from 0 to a quarter turn in the octave below ``cut``."""
    return np.pi / 2 * (np.clip(np.log2(np.maximum(radius, 1e-12) / cut), -1, 0) + 1)


def energy_correlations(picture: np.ndarray) -> np.ndarray:
    """Return correlations of local energies: of every pair of bands, and of each with itself shifted."""
    bands = np.abs(list(analytic_bands(np.pad(picture, 8), scales=3, decimate=False)))
    bands -= bands.mean(axis=(1, 2), keepdims=True)
    bands /= bands.std(axis=(1, 2), keepdims=True) + 1e-12
    flat = bands.reshape(len(bands), -1)
    across = (flat @ flat.T / flat.shape[1])[np.triu_indices(len(bands), 1)]
    along = []
    for i, band in enumerate(bands):
        far = 2 ** (i // 4 + 1)
        shifts = (far, 0), (0, far), (far, far), (far, -far)
        along += [np.mean(band * np.roll(band, shift, (0, 1))) for shift in shifts]
    return np.concatenate([across, along])


def radial_spectrum(picture: np.ndarray, rings: int = 24) -> np.ndarray:
    """Return the power spectrum averaged over rings of equal logarithmic width."""
    rows, columns = picture.shape
    window = np.outer(np.hanning(rows), np.hanning(columns))
    power = np.abs(np.fft.fft2((picture - picture.mean()) * window)) ** 2
    length = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns))
    edges = np.geomspace(2 / min(rows, columns), 0.45, rings + 1)
    ring = np.digitize(length, edges) - 1
    inside = (ring >= 0) & (ring < rings)
    count = np.bincount(ring[inside], minlength=rings)
    total = np.bincount(ring[inside], power[inside], rings)
    return total[count > 0] / count[count > 0]

"""The steerable pyramid with complex bands: every real band with its quadrature pair (Portilla and Simoncelli 2000).

The imaginary part of a band is its Hilbert transform along the band's direction, so that the magnitude is the local
strength of a structure and the phase its kind, line or edge, whatever its position. The real parts alone are the tight
frame of ``SteerablePyramid`` and put the image together again.
"""

from dataclasses import dataclass

import numpy as np

from warpfluid.reconstruction.pyramid import SteerablePyramid, add_cropped, crop, polar


@dataclass(frozen=True)
class Levels:
    """An image taken apart.

    Attributes:
        highpass: Shape (..., rows, columns).
        bands: For each scale, fine to coarse, complex, shape (..., band, rows, columns).
        lows: What is left before each scale is split off, and after the last, shape (..., rows, columns).
    """

    highpass: np.ndarray
    bands: list[np.ndarray]
    lows: list[np.ndarray]


class AnalyticPyramid(SteerablePyramid):
    """Decompose batches of real images into complex oriented bands; arguments as those of ``SteerablePyramid``."""

    def __init__(self, shape: tuple[int, int], height: int = 4, order: int = 3, dtype=np.float32):
        super().__init__(shape, height, order, dtype)
        self._quarter_turns = [self._quarter_turn(size) for size in self.sizes[:-1]]

    def analyze(self, images: np.ndarray) -> Levels:
        """Take images apart, shape (..., rows, columns)."""
        spectrum = self._forward(np.asarray(images, self.dtype))
        highpass = self._inverse(spectrum * self._highpass, self.shape)
        low, lows, bands = spectrum * self._lowpass, [], []
        for scale, filters in enumerate(self._oriented):
            lows.append(self._inverse(low, self.sizes[scale]))
            split = low[..., None, :, :] * np.stack(filters)
            bands.append(self._complex(split, scale))
            low = crop(low, self.sizes[scale + 1]) * self._halving[scale]
        return Levels(highpass, bands, [*lows, self._inverse(low, self.sizes[-1])])

    def analytic(self, bands: np.ndarray, scale: int) -> np.ndarray:
        """Return the complex bands of real ones, shape (..., band, rows, columns)."""
        return self._complex(self._forward(np.asarray(bands, self.dtype)), scale)

    def merge(self, low: np.ndarray, bands: np.ndarray, scale: int) -> np.ndarray:
        """Return what a scale was split off from: the low-pass above it of the next coarser one and its real bands."""
        filters = np.conj(np.stack(self._oriented[scale]))
        total = (self._forward(np.asarray(bands, self.dtype)) * filters).sum(axis=-3)
        low = self._forward(np.asarray(low, self.dtype)) * self._halving[scale]
        add_cropped(total, low, self.sizes[scale + 1])
        return self._inverse(total, self.sizes[scale])

    def finish(self, low: np.ndarray, highpass: np.ndarray) -> np.ndarray:
        """Put images together again from their finest low-pass and their high-pass."""
        low, highpass = (self._forward(np.asarray(part, self.dtype)) for part in (low, highpass))
        return self._inverse(low * self._lowpass + highpass * self._highpass, self.shape)

    def widen(self, bands: np.ndarray, scale: int) -> np.ndarray:
        """Interpolate complex bands of a scale to the size of the next finer one."""
        size = self.sizes[scale - 1]

        def wide(part: np.ndarray) -> np.ndarray:
            spectrum = self._forward(part)
            total = np.zeros((*part.shape[:-2], size[0], size[1] // 2 + 1), spectrum.dtype)
            add_cropped(total, spectrum, self.sizes[scale])
            return self._inverse(total, size)

        return wide(bands.real) + 1j * wide(bands.imag)

    def _complex(self, spectrum: np.ndarray, scale: int) -> np.ndarray:
        real = self._inverse(spectrum, self.sizes[scale])
        return real + 1j * self._inverse(spectrum * self._quarter_turns[scale], self.sizes[scale])

    def _quarter_turn(self, size: tuple[int, int]) -> np.ndarray:
        """Return the Hilbert transforms along the directions of the bands, shape (band, rows, columns)."""
        _, direction = polar(size, self.shape)
        count = self.order + 1
        turns = [-1j * np.sign(np.cos(direction - np.pi * band / count)) for band in range(count)]
        return np.stack(turns).astype(np.result_type(self.dtype, np.complex64))

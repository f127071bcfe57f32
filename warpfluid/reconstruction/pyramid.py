"""The steerable pyramid: scales and orientations of a picture (Section 3.2, Fig. 4; Simoncelli and Freeman 1995).

Polar-separable filters in the Fourier domain. Two details make it a tight frame for every image size, odd and prime
ones too: frequencies are symmetric about zero, and a level of n samples is halved to ceil(n / 2), whose Nyquist
frequency is never below the support of the low-pass. So the sum of squares of all coefficients is that of the
pixels (Parseval), and collapse, the adjoint of build, inverts it.
"""

import functools
import math
from collections.abc import Callable, Hashable

import numpy as np
import scipy.fft

Bands = dict[Hashable, np.ndarray]

HIGHPASS, LOWPASS = "highpass", "lowpass"


class SteerablePyramid:
    """Decompose batches of real images into a high-pass, ``order + 1`` oriented bands a scale, and a low-pass.

    Coefficients are a dictionary: ``"highpass"``, ``(scale, band)`` with scale 0 the finest, ``"lowpass"``. Band b is
    made of derivatives along the direction b / (order + 1) * 180 degrees, counted from the last axis to the first.
    The high-pass may be parted by direction, too: ``("highpass", part)`` is what changes along the last axis, along
    both diagonals, and along the first axis.

    Args:
        shape: Size of an image.
        height: Number of scales.
        order: Order of the derivatives; 3 gives the paper's four orientations.
        dtype: Precision of images and coefficients.
        decimate: Halve the size from scale to scale; off, every band has the image's size.
        part_highpass: Part the high-pass by direction.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        height: int = 4,
        order: int = 3,
        dtype=np.float32,
        *,
        decimate: bool = True,
        part_highpass: bool = False,
    ):
        if height < 1 or order < 0 or min(shape) < 2:
            raise ValueError(f"shape {shape}, height {height}, order {order}: expected >= 2 pixels, >= 1 scale, >= 0")
        self.shape, self.height, self.order = (int(shape[0]), int(shape[1])), height, order
        self.dtype = np.dtype(dtype)
        self.sizes = [self.shape]
        for _ in range(height):
            rows, columns = self.sizes[-1]
            self.sizes.append(((rows + 1) // 2, (columns + 1) // 2) if decimate else (rows, columns))
        self._make_filters(decimate)
        self._highs = {HIGHPASS: self._highpass}
        if part_highpass:
            self._highs = {(HIGHPASS, i): self._highpass * part for i, part in enumerate(self._directions())}

    @property
    def keys(self) -> list[Hashable]:
        """The bands, fine to coarse."""
        return [*self._highs, *((s, b) for s in range(self.height) for b in range(self.order + 1)), LOWPASS]

    def build(self, images: np.ndarray, visit: Callable[[Hashable, np.ndarray], np.ndarray] | None = None) -> Bands:
        """Decompose images.

        Args:
            images: Shape (..., rows, columns).
            visit: Called with key and band as soon as a band exists, returns what is kept.

        Returns:
            The coefficients; a band of scale s has size ``sizes[s]``.
        """
        visit = visit or (lambda key, band: band)
        spectrum = self._forward(np.asarray(images, self.dtype))
        highs = self._highs.items()
        bands = {key: visit(key, self._inverse(spectrum * high, self.shape)) for key, high in highs}
        low = spectrum * self._lowpass
        for scale, filters in enumerate(self._oriented):
            for band, band_filter in enumerate(filters):
                key = (scale, band)
                bands[key] = visit(key, self._inverse(low * band_filter, self.sizes[scale]))
            low = crop(low, self.sizes[scale + 1]) * self._halving[scale]
        bands[LOWPASS] = visit(LOWPASS, self._inverse(low, self.sizes[-1]))
        return bands

    def collapse(self, bands: Bands) -> np.ndarray:
        """Put images together again: the adjoint of ``build`` and its inverse."""
        low = self._forward(bands[LOWPASS])
        for scale in reversed(range(self.height)):
            rows, columns = self.sizes[scale]
            total = np.zeros((*low.shape[:-2], rows, columns // 2 + 1), low.dtype)
            add_cropped(total, low * self._halving[scale], self.sizes[scale + 1])
            for band, band_filter in enumerate(self._oriented[scale]):
                total += self._forward(bands[scale, band]) * np.conj(band_filter)
            low = total
        total = low * self._lowpass
        for key, high in self._highs.items():
            total += self._forward(bands[key]) * high
        return self._inverse(total, self.shape)

    def _make_filters(self, decimate: bool) -> None:
        bands = self.order + 1
        norm = 2.0**self.order * math.factorial(self.order)
        norm /= math.sqrt(bands * math.factorial(2 * self.order))
        complex_dtype = np.result_type(self.dtype, np.complex64)
        self._oriented, self._halving = [], []
        for scale, size in enumerate(self.sizes):
            radius, direction = polar(size, self.shape)
            if scale == 0:
                self._highpass = _rising(radius, np.pi).astype(self.dtype)
                self._lowpass = _falling(radius, np.pi).astype(self.dtype)
            else:
                self._halving.append(self._halving_filter(radius, scale, size, decimate))
            if scale < self.height:
                ring = 1j**self.order * norm * _rising(radius, np.pi / 2 ** (scale + 1))  # i^order: real bands
                lobes = (np.cos(direction - np.pi * band / bands) ** self.order for band in range(bands))
                self._oriented.append([(ring * lobe).astype(complex_dtype) for lobe in lobes])

    def _directions(self) -> list[np.ndarray]:
        """Return what parts the high-pass; squares add up to 1.

        Both diagonals are one, for at the Nyquist frequency, which matters here, they cannot be told apart.
        """
        _, direction = polar(self.shape, self.shape)
        lobes = [0.8 * np.cos(direction - np.pi * band / 4) ** 6 for band in range(4)]
        parts = (lobes[0], lobes[1] + lobes[3], lobes[2])
        return [np.sqrt(part).astype(self.dtype) for part in parts]

    def _halving_filter(self, radius: np.ndarray, scale: int, size: tuple[int, int], decimate: bool) -> np.ndarray:
        low = _falling(radius, np.pi / 2**scale)
        if decimate:  # the Nyquist frequency of an even size has no mirror image; it carries no energy here
            if size[0] % 2 == 0:
                low[size[0] // 2, :] = 0.0
            if size[1] % 2 == 0:
                low[:, size[1] // 2] = 0.0
        return low.astype(self.dtype)

    @staticmethod
    def _forward(images: np.ndarray) -> np.ndarray:
        return scipy.fft.rfft2(images, norm="ortho")

    @staticmethod
    def _inverse(spectrum: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        return scipy.fft.irfft2(spectrum, s=size, norm="ortho")


@functools.lru_cache(maxsize=8)
def shared_pyramid(shape: tuple[int, int], height: int, *, part_highpass: bool = False) -> SteerablePyramid:
    """Return the third-order pyramid of a shape; frames of a sequence share its filters."""
    return SteerablePyramid(shape, height, part_highpass=part_highpass)


def default_height(shape: tuple[int, int]) -> int:
    """Return how many scales suit a picture: 4 from 128 pixels, one fewer each time the shorter side halves."""
    return max(1, min(4, int(math.log2(min(shape))) - 3))


def padded_shape(shape: tuple[int, int], margin: int = 16) -> tuple[int, int]:
    """Return a size that is fast to transform and leaves a margin, so that fluid at one edge does not wrap round."""
    return tuple(scipy.fft.next_fast_len(length + margin, real=True) for length in shape)


def polar(size: tuple[int, int], full: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [radian/pixel of the full image] and directions [radian] of a half spectrum."""
    rows = np.rint(scipy.fft.fftfreq(size[0]) * size[0]) * 2 * np.pi / full[0]
    columns = np.rint(scipy.fft.rfftfreq(size[1]) * size[1]) * 2 * np.pi / full[1]
    rows, columns = np.meshgrid(rows, columns, indexing="ij")
    return np.hypot(rows, columns), np.arctan2(rows, columns)


def _octave(radius: np.ndarray, cut: float) -> np.ndarray:
    """-1 up to half the cut, 0 from the cut, linear in octaves between."""
    return np.clip(np.log2(np.maximum(radius, 1e-12) / cut), -1.0, 0.0)


def _falling(radius: np.ndarray, cut: float) -> np.ndarray:
    return np.cos(0.5 * np.pi * (_octave(radius, cut) + 1.0))


def _rising(radius: np.ndarray, cut: float) -> np.ndarray:
    return np.sin(0.5 * np.pi * (_octave(radius, cut) + 1.0))


def _corners(size: tuple[int, int]) -> tuple[slice, slice, slice]:
    """Rows of the positive and negative frequencies, and the columns, that a spectrum of a size keeps."""
    positive, negative = (size[0] - 1) // 2 + 1, (size[0] - 1) // 2
    return slice(0, positive), slice(-negative or None, None) if negative else slice(0, 0), slice(0, (size[1] + 1) // 2)


def crop(spectrum: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Cut a half spectrum to the frequencies of a smaller image, without the Nyquist frequencies of even sizes."""
    target = (*spectrum.shape[:-2], size[0], size[1] // 2 + 1)
    if target == spectrum.shape:
        return spectrum
    out = np.zeros(target, spectrum.dtype)
    positive, negative, columns = _corners(size)
    out[..., positive, columns] = spectrum[..., positive, columns]
    out[..., negative, columns] = spectrum[..., negative, columns]
    return out


def add_cropped(total: np.ndarray, spectrum: np.ndarray, size: tuple[int, int]) -> None:
    """Add the half spectrum of a smaller image to that of a larger one, in place: the adjoint of ``crop``."""
    if total.shape == spectrum.shape:
        total += spectrum
        return
    positive, negative, columns = _corners(size)
    total[..., positive, columns] += spectrum[..., positive, columns]
    total[..., negative, columns] += spectrum[..., negative, columns]

"""How near a picture is to the truth: the numbers of Section 5, and those that no histogram can game.

Appearance transfer matches intensities and the sub-bands of a steerable pyramid, so a made view scores well
in these two by construction: they are reported, but never rank. The independent numbers look at patches, the
power spectrum, filaments and the length of outlines. Nearly all compare statistics, not pixels: in an unseen
view a sharp flame in the wrong place beats a grey average, while pixel by pixel the average wins.

Pictures are (rows, columns), top row first, white at 255. The candidate comes first, the truth second.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

SMALLEST_SIDE = 25  # three Laplacian levels of it still hold a 7 x 7 patch
TINY = 1e-9


@dataclass(frozen=True)
class Metric:
    """One number of the table.

    The method itself matches what is ``tuned`` and knows nothing of what is ``independent``; ``physical``
    compares light and place; ``volume`` is measured on the volume and has no ``measure``.
    """

    name: str  # key in the results
    label: str  # for people
    best: Literal["low", "high", "one"]  # where the good values are
    group: Literal["tuned", "independent", "physical", "volume"]
    meaning: str  # what it sees
    measure: Callable[[np.ndarray, np.ndarray], float] | None = None
    anywhere: bool = True  # holds between views of one moment from any two angles


def compare_pictures(candidate: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    """Measure a picture against the true picture at the same angle.

    Args:
        candidate: Grey picture, shape (rows, columns).
        truth: The true one, same shape.

    Returns:
        The value of every metric of pictures, by name, in the order of ``METRICS``.

    Raises:
        ValueError: If the shapes differ or are too small, a value is not finite, or the truth is black.
    """
    candidate, truth = _pair(candidate, truth)
    return {m.name: float(m.measure(candidate, truth)) for m in METRICS.values() if m.measure}


def appearance_distance(candidate: np.ndarray, references: Sequence[np.ndarray]) -> dict[str, float]:
    """Measure a picture against footage from other angles, for want of the truth.

    Only metrics that hold between different angles take part. Views of one fluid differ, too: the references'
    distance from each other is the floor, not zero.

    Args:
        candidate: Grey picture, shape (rows, columns).
        references: Pictures of the same moment from any angle, same shape.

    Returns:
        The mean over the references of every metric that needs no truth, by name.

    Raises:
        ValueError: As ``compare_pictures``, or if there are no references.
    """
    if len(references) == 0:
        raise ValueError("references is empty; give at least one input picture")
    pairs = [_pair(candidate, reference) for reference in references]
    chosen = [m for m in METRICS.values() if m.anywhere and m.measure]
    return {m.name: float(np.mean([m.measure(*pair) for pair in pairs])) for m in chosen}


def wasserstein(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the Wasserstein distance (W1) of the values, in standard deviations of the truth."""
    apart = np.abs(np.sort(candidate, axis=None) - np.sort(truth, axis=None))
    return float(apart.mean() / max(truth.std(), TINY))


def band_w1(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the mean Wasserstein distance of the oriented sub-bands, four scales of four orientations."""
    from scipy.fft import next_fast_len

    # A black margin keeps flames at one border from wrapping around to the other.
    margin = [(0, next_fast_len(n + 16, real=True) - n) for n in truth.shape]
    a, b = (_analytic_bands(np.pad(p, margin), scales=4, decimate=True) for p in (candidate, truth))
    return float(np.mean([wasserstein(p.imag, q.imag) for p, q in zip(a, b, strict=True)]))


def patch_swd(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the sliced Wasserstein distance of 7 x 7 patches, mean of three Laplacian levels."""
    from scipy.ndimage import gaussian_filter

    directions = np.random.default_rng(0).standard_normal((64, 49))
    directions -= directions.mean(axis=1, keepdims=True)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)

    def shadows(detail: np.ndarray) -> np.ndarray:
        patches = np.lib.stride_tricks.sliding_window_view(detail, (7, 7)).reshape(-1, 49)
        return np.sort(patches @ directions.T, axis=0)

    distances = []
    for _ in range(3):
        smooth = [gaussian_filter(picture, 1.0, mode="constant") for picture in (candidate, truth)]
        a, b = shadows(candidate - smooth[0]), shadows(truth - smooth[1])
        distances.append(np.mean(np.abs(a - b).mean(axis=0) / np.maximum(b.std(axis=0), TINY)))
        candidate, truth = (picture[::2, ::2] for picture in smooth)
    return float(np.mean(distances))


def log_spectrum(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the rms difference of the radial power spectra, in decades: blur, moire, over-sharpening."""
    a, b = (np.log10(_radial_spectrum(picture) + 1e-12) for picture in (candidate, truth))
    return float(np.sqrt(np.mean((a - b) ** 2)))


def gradient_w1(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the Wasserstein distance of the gradients' lengths, in standard deviations of the truth."""
    from scipy.ndimage import sobel

    a, b = (np.hypot(sobel(picture, 0), sobel(picture, 1)) for picture in (candidate, truth))
    return wasserstein(a, b)


def magnitudes(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the rms difference of the local energies' correlations (after Portilla and Simoncelli 2000)."""
    a, b = _energy_correlations(candidate), _energy_correlations(truth)
    return float(np.sqrt(np.mean((a - b) ** 2)))


def perimeter(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the relative error of the outlines' length at six of the truth's grey levels."""
    levels = np.quantile(truth[truth > 0], [0.2, 0.4, 0.6, 0.75, 0.9, 0.97])

    def lengths(picture: np.ndarray) -> np.ndarray:
        lit = [picture > level for level in levels]
        return np.array([(m[1:] != m[:-1]).sum() + (m[:, 1:] != m[:, :-1]).sum() for m in lit], float)

    a, b = lengths(candidate), lengths(truth)
    return float(np.abs(a - b).mean() / max(b.mean(), TINY))


def row_mass(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the relative error of the rows' totals, which orthographic views of emission share."""
    return float(np.abs(candidate.sum(axis=1) - truth.sum(axis=1)).sum() / max(truth.sum(), TINY))


def silhouette(candidate: np.ndarray, truth: np.ndarray, threshold: float = 2.0) -> float:
    """Return one minus intersection over union of what is brighter than ``threshold`` [grey level]."""
    a, b = candidate > threshold, truth > threshold
    return float(1 - (a & b).sum() / (a | b).sum()) if (a | b).any() else 0.0


def gradient_ratio(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the horizontal detail over the truth's: below one is blurred, above is too sharp."""
    return _roughness(candidate, 1) / max(_roughness(truth, 1), TINY)


def streak(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return vertical over horizontal detail, over the truth's: above one are combs between heights."""
    a, b = (_roughness(picture, 0) / max(_roughness(picture, 1), TINY) for picture in (candidate, truth))
    return a / max(b, TINY)


def psnr(candidate: np.ndarray, truth: np.ndarray, white: float = 255.0) -> float:
    """Return the peak signal-to-noise ratio [dB], finite even for an exact copy."""
    rms = np.sqrt(np.mean((candidate - truth) ** 2, dtype=np.float64))
    return float(20 * np.log10(white / max(rms, TINY)))


def grid_index(volume: np.ndarray, angles_deg: Sequence[float] = (0, 90), half_width_deg: float = 6) -> float:
    """Measure how much a volume is woven along its inputs' rays, the mark of least squares.

    Args:
        volume: Density, shape (x, z, y).
        angles_deg: Angles of the input views.
        half_width_deg: How far from an input's direction energy counts as belonging to it.

    Returns:
        Energy of the slices' spectrum near the inputs' directions over an isotropic one's: natural fluid has
        about 1, least squares from two views 3 to 6.

    Raises:
        ValueError: If the volume is not 3D, too small to have a spectrum, or without structure.
    """
    volume = np.asarray(volume)
    if volume.ndim != 3 or min(volume.shape[:2]) < 8:
        raise ValueError(f"volume has shape {volume.shape}; slices of at least 8 x 8, (x, z, y), are needed")
    window = np.outer(np.hanning(volume.shape[0]), np.hanning(volume.shape[1]))
    power = np.zeros(window.shape)
    for k in range(volume.shape[2]):
        level = volume[:, :, k].astype(np.float64)
        power += np.abs(np.fft.fft2((level - level.mean()) * window)) ** 2
    fx, fz = (np.fft.fftfreq(n) for n in window.shape)
    length, direction = np.hypot(fx[:, None], fz), np.degrees(np.arctan2(fz, fx[:, None]))
    ring = (length > 0.06) & (length < 0.4)  # below is the silhouette, above the interpolation
    apart = [np.abs((direction - angle + 90) % 180 - 90) for angle in angles_deg]
    near = ring & (np.min(apart, axis=0) < half_width_deg)
    if not power[ring].any() or not near.any():
        raise ValueError("volume has no structure to measure; leave an empty frame out")
    return float(power[near].sum() / power[ring].sum() * ring.sum() / near.sum())


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric("intensity_w1", "Intensity W1", "low", "tuned", "grey values", wasserstein),
        Metric("band_w1", "Sub-band W1", "low", "tuned", "detail by scale and direction", band_w1),
        Metric("patch_swd", "Patch SWD", "low", "independent", "small patches at three scales", patch_swd),
        Metric("log_spectrum", "Log spectrum", "low", "independent", "blur, over-sharpening", log_spectrum),
        Metric("gradient_w1", "Gradient W1", "low", "independent", "steepness of edges", gradient_w1),
        Metric("magnitudes", "Magnitudes", "low", "independent", "filaments against speckle", magnitudes),
        Metric("perimeter", "Perimeter", "low", "independent", "wisps against blobs", perimeter),
        Metric("gradient_ratio", "Gradient ratio", "one", "independent", "sharpness across", gradient_ratio),
        Metric("streak", "Streak", "one", "independent", "combs between heights", streak),
        Metric("row_mass", "Row mass", "low", "physical", "light at every height", row_mass),
        Metric("silhouette", "Silhouette", "low", "physical", "lit area in its place", silhouette, False),
        Metric("psnr", "PSNR [dB]", "high", "physical", "pixel by pixel, for input views", psnr, False),
        Metric("grid_index", "Grid index", "one", "volume", "slices woven along the rays"),
    )
}


def _pair(candidate: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both pictures as float64, checked."""
    pair = np.asarray(candidate, np.float64), np.asarray(truth, np.float64)
    shapes = pair[0].shape, pair[1].shape
    if shapes[0] != shapes[1] or pair[0].ndim != 2:
        found = " and ".join(map(str, shapes))
        raise ValueError(f"candidate and truth have shapes {found}; two grey pictures of one size are needed")
    if min(shapes[0]) < SMALLEST_SIDE:
        raise ValueError(f"pictures are {shapes[0]}; at least {SMALLEST_SIDE} pixels a side are needed")
    for name, picture in zip(("candidate", "truth"), pair, strict=True):
        if not np.isfinite(picture).all():
            raise ValueError(f"{name} holds values that are not finite; replace them by 0 first")
    if not (pair[1] > 0).any():
        raise ValueError("truth is black everywhere, so nothing can be measured in it; leave this frame out")
    return pair


def _roughness(picture: np.ndarray, axis: int) -> float:
    """Return the mean step between neighbours along an axis."""
    return float(np.abs(np.diff(picture, axis=axis)).mean())


def _analytic_bands(picture: np.ndarray, scales: int, decimate: bool) -> Iterator[np.ndarray]:
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


def _energy_correlations(picture: np.ndarray) -> np.ndarray:
    """Return correlations of local energies: of every pair of bands, and of each with itself shifted."""
    bands = np.abs(list(_analytic_bands(np.pad(picture, 8), scales=3, decimate=False)))
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


def _radial_spectrum(picture: np.ndarray, rings: int = 24) -> np.ndarray:
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

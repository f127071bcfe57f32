"""Numbers of two pictures: a candidate and the truth, grey, float64, shape (rows, columns), top row first.

Nearly all compare statistics, not pixels: in an unseen view a sharp flame in the wrong place beats a grey average,
while pixel by pixel the average wins.
"""

import numpy as np

from warpfluid.metrics.spectra import analytic_bands, energy_correlations, radial_spectrum

TINY = 1e-9


def wasserstein(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the Wasserstein distance (W1) of the values, in standard deviations of the truth."""
    apart = np.abs(np.sort(candidate, axis=None) - np.sort(truth, axis=None))
    return float(apart.mean() / max(truth.std(), TINY))


def band_w1(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the mean Wasserstein distance of the oriented sub-bands, four scales of four orientations."""
    from scipy.fft import next_fast_len

    # A black margin keeps flames at one border from wrapping around to the other.
    margin = [(0, next_fast_len(n + 16, real=True) - n) for n in truth.shape]
    a, b = (analytic_bands(np.pad(p, margin), scales=4, decimate=True) for p in (candidate, truth))
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
    a, b = (np.log10(radial_spectrum(picture) + 1e-12) for picture in (candidate, truth))
    return float(np.sqrt(np.mean((a - b) ** 2)))


def gradient_w1(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the Wasserstein distance of the gradients' lengths, in standard deviations of the truth."""
    from scipy.ndimage import sobel

    a, b = (np.hypot(sobel(picture, 0), sobel(picture, 1)) for picture in (candidate, truth))
    return wasserstein(a, b)


def magnitudes(candidate: np.ndarray, truth: np.ndarray) -> float:
    """Return the rms difference of the local energies' correlations (after Portilla and Simoncelli 2000)."""
    a, b = energy_correlations(candidate), energy_correlations(truth)
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


def ssim(candidate: np.ndarray, truth: np.ndarray, white: float = 255.0) -> float:
    """Return the structural similarity (Wang et al. 2004), 1 for an exact copy."""
    from skimage.metrics import structural_similarity

    return float(structural_similarity(candidate, truth, data_range=white))


def _roughness(picture: np.ndarray, axis: int) -> float:
    """Return the mean step between neighbours along an axis."""
    return float(np.abs(np.diff(picture, axis=axis)).mean())

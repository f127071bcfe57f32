"""Texture optimisation in the M-step (Kwatra et al. 2005): the paper's experiment of Fig. 16, which fails.

A view is made of patches of the two inputs that it lies between. From coarse to fine, every patch of the view looks
for the most similar one of the inputs, and the view becomes the weighted mean of all that were found. Patches that fit
badly count less, which makes the sum of the distances to the power 0.8 fall instead of that of their squares.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.ndimage import zoom
from scipy.spatial import KDTree

from warpfluid.kernels.launch import thread_count
from warpfluid.reconstruction.neighbours import around, between

LEVELS = 3  # each of half the size
ITERATIONS = 4  # at each level
POWER = 0.8  # of the distances
COMPONENTS = 20
VARIANCE = 0.97  # what the principal components hold
FALLOFF = 0.35  # deviation of a patch's weights over its size
DARK = 0.5  # a patch with no pixel above this is black [grey level]


class TextureOptimization:
    """The M-step of a fan of views, made of patches of the inputs.

    Args:
        images: Input images, shape (view, u, v).
        angles_deg: Their angles, distinct and in [0, 180) [degree].
        fan_deg: Angles of the views to transfer to, in [0, 180) [degree].
        patch: Size of a patch [pixel], the same at all levels.
    """

    def __init__(
        self, images: np.ndarray, angles_deg: tuple[float, ...], fan_deg: tuple[float, ...], *, patch: int = 16
    ):
        size = min(images.shape[1:])
        if patch > size:
            raise ValueError(f"patch is {patch}, larger than the images of {size} pixels; take at most {size}")
        images, angles = around(images, angles_deg)
        self._pairs, _ = between(angles, fan_deg)
        levels = pyramid(images, patch)
        self._exemplars = {p: [Exemplars(level[p : p + 2], patch) for level in levels] for p in np.unique(self._pairs)}
        self._patch = patch

    def transfer(self, rendered: np.ndarray, mask: np.ndarray) -> np.ndarray:
        """Modify rendered views so that all their patches look like some of the inputs.

        Args:
            rendered: One view for each angle of the fan, shape (angle, u, v).
            mask: Projection of the visual hull, bool, shape of ``rendered``; outside it the result is 0.

        Returns:
            The modified views, shape of ``rendered``; the same for any number of threads.
        """

        def work(pair: int, image: np.ndarray) -> np.ndarray:
            return optimize(image, self._exemplars[pair], self._patch)[0]

        with ThreadPoolExecutor(thread_count()) as pool:
            made = list(pool.map(work, self._pairs, rendered))
        return np.stack(made) * mask


class Exemplars:
    """All patches of some images, found by their principal components.

    Args:
        images: Shape (view, u, v).
        patch: Size of a patch.
    """

    def __init__(self, images: np.ndarray, patch: int):
        stride = max(1, patch // 8)
        windows = [_windows(_padded(image, patch), patch, stride).reshape(-1, patch * patch) for image in images]
        patches = np.concatenate(windows)
        lit = patches[patches.max(axis=1) > DARK]
        self.patches = np.concatenate([np.zeros((1, patch * patch), np.float32), lit])
        variances, axes = np.linalg.eigh(self.patches.T.astype(np.float64) @ self.patches)
        share = np.cumsum(variances[::-1]) / max(variances.sum(), 1e-12)
        count = min(COMPONENTS, int(np.searchsorted(share, VARIANCE)) + 1)
        self._axes = axes[:, ::-1][:, :count].astype(np.float32)
        self._tree = KDTree(self.patches @ self._axes)

    def nearest(self, patches: np.ndarray) -> np.ndarray:
        """Return which patch is most similar to each of those given; black ones are the first."""
        found = np.zeros(len(patches), np.int64)
        lit = np.flatnonzero(patches.max(axis=1) > DARK)
        if lit.size:
            found[lit] = self._tree.query(patches[lit] @ self._axes)[1]
        return found


def optimize(image: np.ndarray, exemplars: list[Exemplars], patch: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Make an image of patches of the exemplars.

    Args:
        image: Where to begin, shape (u, v).
        exemplars: Those of every level, fine to coarse.
        patch: Size of a patch.

    Returns:
        The image, and the energy of each iteration of every level, coarse to fine: the sum of the distances between
        patches and those found, to the power 0.8.
    """
    levels = [image.astype(np.float32)]
    while len(levels) < len(exemplars):
        levels.append(halved(levels[-1][None])[0])
    energies, change = [], None
    for start, known in zip(reversed(levels), reversed(exemplars), strict=True):
        if change is not None:
            start = np.maximum(start + _doubled(change, start.shape), 0)
        made, energy = _iterate(start, known, patch)
        change = made - levels[len(levels) - 1 - len(energies)]
        energies.append(energy)
    return made, energies


def pyramid(images: np.ndarray, patch: int) -> list[np.ndarray]:
    """Return images at full size, half, and a quarter, as long as they are twice as large as a patch."""
    levels = [images]
    while len(levels) < LEVELS and min(levels[-1].shape[1:]) >= 4 * patch:
        levels.append(halved(levels[-1]))
    return levels


def halved(images: np.ndarray) -> np.ndarray:
    """Return images of half the size, rounded up; each pixel is the mean of four, black beyond the edge."""
    _, width, rows = images.shape
    even = np.pad(images, ((0, 0), (0, width % 2), (0, rows % 2)))
    return 0.25 * (even[:, ::2, ::2] + even[:, 1::2, ::2] + even[:, ::2, 1::2] + even[:, 1::2, 1::2])


def _iterate(image: np.ndarray, exemplars: Exemplars, patch: int) -> tuple[np.ndarray, np.ndarray]:
    """Alternate the search for patches and their mean at one level."""
    padded = _padded(image, patch)
    stride = max(1, patch // 4)
    places = _windows(np.arange(padded.size).reshape(padded.shape), patch, stride).reshape(-1)
    reach = (np.arange(patch) - (patch - 1) / 2) / (FALLOFF * patch)
    falloff = np.exp(-0.5 * (reach[:, None] ** 2 + reach**2)).ravel()
    before, energies = None, []
    for _ in range(ITERATIONS):
        patches = _windows(padded, patch, stride).reshape(-1, patch * patch)
        found = exemplars.nearest(patches)
        if before is not None and (found == before).all():
            break
        wanted, before = exemplars.patches[found], found
        distance = np.square(wanted - patches).sum(axis=1, dtype=np.float64)
        energies.append((distance ** (POWER / 2)).sum())
        weights = (distance + patch * patch)[:, None] ** (POWER / 2 - 1) * falloff
        total = np.bincount(places, weights.ravel(), padded.size)
        mean = np.bincount(places, (weights * wanted).ravel(), padded.size) / np.maximum(total, 1e-30)
        padded = mean.reshape(padded.shape).astype(np.float32)
    width, rows = image.shape
    return padded[patch : patch + width, patch : patch + rows], np.array(energies)


def _padded(image: np.ndarray, patch: int) -> np.ndarray:
    """Surround an image by black, wider beyond its end, so that patches cover all of it."""
    return np.pad(image, ((patch, patch + patch // 4), (patch, patch + patch // 4)))


def _windows(image: np.ndarray, patch: int, stride: int) -> np.ndarray:
    return np.lib.stride_tricks.sliding_window_view(image, (patch, patch))[::stride, ::stride]


def _doubled(image: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return an image of twice the size, cut to a shape."""
    return zoom(image, 2, order=1, mode="nearest", grid_mode=True)[: shape[0], : shape[1]]

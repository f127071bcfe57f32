"""What the M-steps have in common: a fan of views, padded to a pyramid's shape, modified a few at a time."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from warpfluid.kernels.launch import thread_count
from warpfluid.reconstruction.histogram import match

Modify = Callable[[np.ndarray, np.ndarray, slice], np.ndarray]


def modify_views(modify: Modify, rendered: np.ndarray, mask: np.ndarray, *, at_once: int) -> np.ndarray:
    """Modify the views of a fan on all threads.

    Args:
        modify: Takes some rendered views, their mask, and which they are; returns them modified.
        rendered: One view for each angle of the fan, shape (angle, u, v).
        mask: Projection of the visual hull, bool, shape of ``rendered``.
        at_once: How many views are modified together.

    Returns:
        The modified views, shape of ``rendered``; the same for any number of threads.
    """
    out = np.empty(rendered.shape, np.float32)

    def work(begin: int) -> None:
        views = slice(begin, min(begin + at_once, len(rendered)))
        out[views] = modify(rendered[views], mask[views], views)

    with ThreadPoolExecutor(thread_count()) as pool:
        list(pool.map(work, range(0, len(rendered), at_once)))
    return out


def pad_views(images: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return views (view, u, v) in the corner of larger ones of a shape, black elsewhere."""
    padded = np.zeros((len(images), *shape), np.float32)
    padded[:, : images.shape[1], : images.shape[2]] = images
    return padded


def match_intensities(images: np.ndarray, mask: np.ndarray, targets: np.ndarray, ranks: np.ndarray) -> np.ndarray:
    """Give padded views the intensities of their targets inside a mask, and cut them to it; outside it they are 0.

    What lies outside takes the darkest ranks: otherwise rounding would decide which background pixels light up.

    Args:
        images: Padded views, shape (view, u, v).
        mask: Bool, shape (view, u, v) of the views without their padding.
        targets: Sorted values of each view, at ``ranks``.
        ranks: See ``histogram.rank_grid``.
    """
    _, width, height = mask.shape
    inside = np.zeros(images.shape, bool)
    inside[:, :width, :height] = mask
    darkest = np.minimum(images.min(axis=(1, 2), keepdims=True), 0)
    flat = np.ascontiguousarray(np.where(inside, images, darkest), np.float32).reshape(len(images), -1)
    matched = match(flat, targets, ranks, keep_zero=True).reshape(images.shape) * inside
    return matched[:, :width, :height]

"""Motion between two pictures of one view.

``nltv-ncc`` is the paper's choice: non-local total variation and truncated normalised cross-correlation (Werlberger,
Pock and Bischof 2010), from coarse to fine. Pictures are blurred a little, halved until little is left, and the flow
found at each scale is where the next one starts: compare the pictures there, smooth, take medians, and again.
"""

import numpy as np
import warp as wp

from warpfluid.device import pick_device
from warpfluid.kernels.blur import blur
from warpfluid.kernels.flow import correlation, pictures
from warpfluid.kernels.flow.optical_flow import regularize
from warpfluid.kernels.flow.pair_prices import PAIRS, price_pairs

METHODS = ("nltv-ncc", "ilk", "tvl1")

GRAIN = 0.6  # standard deviation of the blur against noise [pixel]
HALVING = 1.0  # the same before the size is halved
SMALLEST = 16  # pixels of the shorter side; there motion of a quarter of the picture is small
COMPARISONS = 5  # of the pictures at each scale
ITERATIONS = 12  # after each of them
WEIGHT = 30.0  # of the pictures' likeness against smoothness


def optical_flow(
    now: np.ndarray,
    later: np.ndarray,
    *,
    method: str = "ilk",
    white: float = 255.0,
    device: str | wp.Device | None = None,
) -> np.ndarray:
    """Measure the motion from one image to the next.

    Args:
        now: Image, shape (u, v).
        later: The next image, the same shape.
        method: ``nltv-ncc``, which a change of brightness does not mislead, ``ilk``, iterative Lucas-Kanade with a
            Gaussian window (Le Besnerais and Champagnat 2005), or ``tvl1`` (Zach, Pock and Bischof 2007).
        white: Pixel value of white.
        device: Where ``nltv-ncc`` computes; the others use the CPU.

    Returns:
        Displacement along u and v [pixel/frame], shape (2, u, v).

    Raises:
        ValueError: If the method is unknown or the shapes differ.
    """
    if now.shape != later.shape:
        raise ValueError(f"later has shape {later.shape}, expected {now.shape} as now has")
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, expected one of {', '.join(METHODS)}")
    a, b = (np.ascontiguousarray(image, np.float32) / np.float32(white) for image in (now, later))
    if method == "nltv-ncc":
        return nltv_ncc(a, b, pick_device(device))
    from skimage.registration import optical_flow_ilk, optical_flow_tvl1

    if method == "ilk":
        return np.asarray(optical_flow_ilk(a, b, gaussian=True, num_warp=20), np.float32)
    return np.asarray(optical_flow_tvl1(a, b, attachment=40), np.float32)


def nltv_ncc(now: np.ndarray, later: np.ndarray, device: wp.Device) -> np.ndarray:
    """Measure the motion between two images of white 1, shape (u, v); return (2, u, v)."""
    pair = wp.array(np.stack([now, later]), dtype=float, device=device)
    scales = _scales(blur(pair, (0.0, GRAIN, GRAIN)))
    flow = wp.zeros_like(scales[-1])
    for pair in reversed(scales):
        flow = refine(_enlarge(flow, pair.shape[1:]), pair[0], pair[1])
    return flow.numpy()


def refine(flow: wp.array, now: wp.array, later: wp.array) -> wp.array:
    """Improve a flow, shape (2, u, v), at one scale of the pictures, shape (u, v)."""
    prices, steps = price_pairs(now)
    dual = wp.zeros((2 * PAIRS, *now.shape), dtype=float, device=now.device)
    for _ in range(COMPARISONS):
        expansion = correlation.expand(now, later, flow, weight=WEIGHT)
        flow = pictures.median(regularize(flow, expansion, prices, steps, dual, iterations=ITERATIONS))
    return flow


def _scales(pair: wp.array) -> list[wp.array]:
    """Return a pair of pictures, shape (2, u, v), at its own size and halved again and again."""
    scales = [pair]
    while min(scales[-1].shape[1:]) >= 2 * SMALLEST:
        size = tuple((length + 1) // 2 for length in scales[-1].shape[1:])
        scales.append(pictures.resize(blur(scales[-1], (0.0, HALVING, HALVING)), size))
    return scales


def _enlarge(flow: wp.array, size: tuple[int, int]) -> wp.array:
    """Return a flow for pictures of a larger size, in their pixels."""
    larger = pictures.resize(flow, size).numpy()
    larger *= np.array([size[0] / flow.shape[1], size[1] / flow.shape[2]], np.float32).reshape(2, 1, 1)
    return wp.array(larger, dtype=float, device=flow.device)

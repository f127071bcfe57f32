"""Whether pictures move as fluids do: what motion does not explain, over the same of the truth or the footage."""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from warpfluid.comparison.measure import upright, views_of
from warpfluid.metrics import left_over
from warpfluid.motion.optical_flow import optical_flow

MEASURED_ANGLES = 3
MEASURED_PAIRS = 6
FLOW = "nltv-ncc"  # the same for all that is compared
WHITE = 255.0

Volume = Callable[[int], np.ndarray]
Images = Callable[[int], np.ndarray | None]


def measured_pairs(frames: Sequence[int], count: int = MEASURED_PAIRS) -> list[tuple[int, int]]:
    """Return pairs of successive frames, spread over all."""
    pairs = [(a, b) for a, b in pairwise(frames) if b - a == min(np.diff(frames))]
    places = np.unique(np.linspace(0, len(pairs) - 1, min(count, len(pairs))).round().astype(int))
    return [pairs[place] for place in places]


def motion_against_truth(
    volumes: Mapping[str, Volume], truth: Volume, frames: Sequence[int], angles_deg: Sequence[float], *, device=None
) -> dict[str, float]:
    """Move pictures along the truth's motion, and compare what is left with what is left of the truth.

    Args:
        volumes: Functions that return the volume of a frame, by name.
        truth: The same of the truth.
        frames: Frames that all have.
        angles_deg: Unseen angles; a few of them are measured.
        device: Where to compute.

    Returns:
        One number a name: 1 is natural motion, more is flicker; nothing if nothing moves.
    """
    angles = spread_angles(angles_deg)
    left = dict.fromkeys(["", *volumes], 0.0)
    for pair in measured_pairs(frames):
        true = _pair_of_views(truth, pair, angles, device)
        back = [_back(*pictures, device) for pictures in true]
        for name, volume in volumes.items():
            views = _pair_of_views(volume, pair, angles, device)
            left[name] += sum(left_over(*pictures, flow) for pictures, flow in zip(views, back, strict=True))
        left[""] += sum(left_over(*pictures, flow) for pictures, flow in zip(true, back, strict=True))
    return {name: left[name] / left[""] for name in volumes} if left[""] else {}


def motion_against_footage(
    volumes: Mapping[str, Volume],
    images: Images,
    frames: Sequence[int],
    angles_deg: Sequence[float],
    *,
    shoulder: float = 0.0,
    pairs: int = MEASURED_PAIRS,
    device=None,
) -> dict[str, float]:
    """Do the same for want of a truth: everything is moved along its own motion, the footage too.

    Args:
        volumes: Functions that return the volume of a frame, by name.
        images: One that returns the footage of a frame, shape (view, u, v), or None.
        frames: Frames that all have.
        angles_deg: Unseen angles; a few of them are measured.
        shoulder: Tone curve of the footage.
        pairs: How many pairs of frames are measured.
        device: Where to compute.
    """
    angles, given, left = spread_angles(angles_deg), [], {name: [] for name in volumes}
    for pair in measured_pairs(frames, pairs):
        footage = [images(frame) for frame in pair]
        if any(image is None for image in footage):
            continue
        given += [left_over(a, b, _back(a, b, device)) for a, b in zip(*map(upright, footage), strict=True)]
        for name, volume in volumes.items():
            views = _pair_of_views(volume, pair, angles, device, shoulder)
            left[name] += [left_over(a, b, _back(a, b, device)) for a, b in views]
    if not given or not np.mean(given):
        return {}
    return {name: float(np.mean(values) / np.mean(given)) for name, values in left.items()}


def speeds(
    images: Images, frames: Sequence[int], *, lit: float = 1.0, pairs: int = MEASURED_PAIRS, device=None
) -> dict[str, float]:
    """Return how fast pictures move over their lit pixels.

    Args:
        images: A function that returns the views of a frame, shape (view, u, v).
        frames: Frames that it has.
        lit: Grey level above which a pixel is lit.
        pairs: How many pairs of frames are measured.
        device: Where to compute.

    Returns:
        ``median`` and ``fast``, below which 95 % of the pixels are [pixel/frame]; nothing for a single frame.
    """
    found = []
    for frame, later in measured_pairs(frames, pairs):
        a, b = images(frame), images(later)
        if a is not None and b is not None:
            flows = (optical_flow(p, q, method=FLOW, white=WHITE, device=device) for p, q in zip(a, b, strict=True))
            found += [np.hypot(*flow)[p > lit] / (later - frame) for flow, p in zip(flows, a, strict=True)]
    moving = np.concatenate(found) if found else np.zeros(0)
    if not moving.size:
        return {}
    return dict(zip(("median", "fast"), map(float, np.percentile(moving, [50, 95])), strict=True))


def spread_angles(angles_deg: Sequence[float]) -> list[float]:
    """Return a few angles out of many."""
    places = np.linspace(0, len(angles_deg) - 1, min(MEASURED_ANGLES, len(angles_deg))).round().astype(int)
    return [angles_deg[place] for place in places]


def _pair_of_views(volume: Volume, pair: tuple[int, int], angles_deg, device, shoulder: float = 0.0) -> list[tuple]:
    """Return the pictures of two frames from every angle."""
    now, later = (views_of(volume(frame), angles_deg, shoulder=shoulder, device=device) for frame in pair)
    return list(zip(now, later, strict=True))


def _back(now: np.ndarray, later: np.ndarray, device) -> np.ndarray:
    """Return the motion from the later picture to the earlier one."""
    return optical_flow(later, now, method=FLOW, white=WHITE, device=device)

"""Numbers of volumes against the truth, or against the footage they were made of, with their floors.

A number alone says little. The floors are what the truth scores against itself seen from a little aside, or mirrored:
a result as near as that cannot be told from another plume of the kind. Without a truth, unseen views are compared with
the footage, and the floors are the views of the footage against each other and against another moment.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, permutations

import numpy as np

from warpfluid.metrics import METRICS, SMALLEST_SIDE, appearance_distance, compare_pictures, grid_index, psnr, ssim

Numbers = dict[str, float]

ASIDE_DEG = (10, 20)
MIRRORED = "truth, mirrored"
OTHER_VIEW, OTHER_FRAME = "footage, other view", "footage, other frame"
STEP_DEG = 15  # between unseen views
NEAREST_DEG = 7.5  # that one of them comes to a given one


def aside(degrees: float) -> str:
    """Return the name of the floor of the truth, seen from aside."""
    return f"truth +{degrees:g}°"


def unseen_angles(given_deg: Sequence[float]) -> tuple[float, ...]:
    """Return angles all around that are not near given ones, or half-way between many; half a turn only mirrors."""
    around = np.arange(0, 180, STEP_DEG)
    apart = [np.abs((around - angle + 90) % 180 - 90) for angle in given_deg] or [np.full(around.shape, 90.0)]
    return tuple(map(float, around[np.min(apart, axis=0) >= NEAREST_DEG])) or tuple(halfway(given_deg))


def halfway(angles_deg: Sequence[float]) -> list[float]:
    """Return the angles half-way between neighbouring views: the farthest from all that is known."""
    angles = sorted(angle % 180 for angle in angles_deg)
    return [(a + b) / 2 for a, b in pairwise([*angles, angles[0] + 180])]


def views_of(volume: np.ndarray, angles_deg: Sequence[float], *, shoulder: float = 0.0, device=None) -> np.ndarray:
    """Return what a volume looks like, shape (angle, rows, columns), top row first.

    Args:
        volume: Density, shape (x, z, y).
        angles_deg: Where the cameras stand.
        shoulder: Tone curve of the footage that it is compared with.
        device: Where to compute.
    """
    from warpfluid.footage.tone import apply_shoulder
    from warpfluid.projector import Projector

    images = Projector(angles_deg, volume.shape, device=device).project(np.ascontiguousarray(volume, np.float32))
    return upright(apply_shoulder(images, shoulder))


def upright(images: np.ndarray) -> np.ndarray:
    """Return images (view, u, v) as pictures (view, rows, columns), top row first."""
    return np.ascontiguousarray(np.asarray(images).transpose(0, 2, 1)[:, ::-1], np.float64)


def against_truth(
    volumes: Mapping[str, np.ndarray],
    truth: np.ndarray,
    given_deg: Sequence[float],
    unseen_deg: Sequence[float],
    *,
    device=None,
) -> dict[str, Numbers]:
    """Measure volumes of one frame against the true one, at the same angles.

    Args:
        volumes: By name, shape (x, z, y).
        truth: The true one, in the same unit.
        given_deg: Angles of the views that they were made of.
        unseen_deg: Angles that are scored.
        device: Where to compute.

    Returns:
        The numbers by name, and those of the floors by theirs; nothing if the truth is black.
    """
    true = views_of(truth, unseen_deg, device=device)
    if not (true.max(axis=(1, 2)) > 0).all():
        return {}
    found = {
        name: _mean(compare_pictures(*pair) for pair in zip(views_of(v, unseen_deg, device=device), true, strict=True))
        for name, v in volumes.items()
    }
    for name, volume in volumes.items():
        found[name]["total"] = float(volume.sum(dtype=np.float64) / truth.sum(dtype=np.float64))
        found[name] |= _woven(volume, given_deg)
    for degrees in ASIDE_DEG:
        beside = views_of(truth, np.asarray(unseen_deg) + degrees, device=device)
        floor = _mean(compare_pictures(*pair) for pair in zip(beside, true, strict=True))
        found[aside(degrees)] = floor | _woven(truth, np.asarray(given_deg) + degrees)
    found[MIRRORED] = _mean(compare_pictures(picture[:, ::-1], picture) for picture in true)
    found[MIRRORED] |= _woven(truth[::-1], given_deg)
    return found


def against_footage(
    volumes: Mapping[str, np.ndarray],
    images: np.ndarray,
    given_deg: Sequence[float],
    unseen_deg: Sequence[float],
    *,
    shoulder: float = 0.0,
    other_frame: np.ndarray | None = None,
    device=None,
) -> dict[str, Numbers]:
    """Measure unseen views of volumes of one frame against the footage, as distributions.

    Args:
        volumes: By name, shape (x, z, y).
        images: The footage, shape (view, u, v).
        given_deg: Angles of the footage.
        unseen_deg: Angles that are scored.
        shoulder: Tone curve of the footage.
        other_frame: The footage at another moment.
        device: Where to compute.

    Returns:
        The numbers by name, and those of the floors by theirs; nothing if a view is black.
    """
    seen = upright(images)
    if min(seen.shape[1:]) < SMALLEST_SIDE or not (seen.max(axis=(1, 2)) > 0).all():
        return {}
    found = {}
    for name, volume in volumes.items():
        pictures = views_of(volume, unseen_deg, shoulder=shoulder, device=device)
        found[name] = _mean(appearance_distance(picture, seen) for picture in pictures)
        found[name] |= _woven(volume, given_deg)
    if len(seen) > 1:
        found[OTHER_VIEW] = _mean(appearance_distance(a, [b]) for a, b in permutations(seen, 2))
    if other_frame is not None:
        pairs = zip(upright(other_frame), seen, strict=True)
        found[OTHER_FRAME] = _mean(appearance_distance(a, [b]) for a, b in pairs)
    return found


def alone(volumes: Mapping[str, np.ndarray], given_deg: Sequence[float]) -> dict[str, Numbers]:
    """Measure what needs neither truth nor footage."""
    return {name: _woven(volume, given_deg) for name, volume in volumes.items()}


def as_given(
    volume: np.ndarray, seen: np.ndarray, given_deg: Sequence[float], *, shoulder: float = 0.0, device=None
) -> Numbers:
    """Return how exactly a volume renders the views that it was made of, and its light over theirs.

    Args:
        volume: Shape (x, z, y).
        seen: The views, shape (view, rows, columns).
        given_deg: Their angles.
        shoulder: Their tone curve.
        device: Where to compute.
    """
    rendered = views_of(volume, given_deg, shoulder=shoulder, device=device)
    pairs = list(zip(rendered, seen, strict=True))
    numbers = {"input_psnr": float(np.mean([psnr(*pair) for pair in pairs]))}
    if min(seen.shape[1:]) >= SMALLEST_SIDE:
        numbers["input_ssim"] = float(np.mean([ssim(*pair) for pair in pairs]))
    return numbers | ({"total": float(rendered.sum() / seen.sum())} if seen.any() else {})


def mean_numbers(frames: Iterable[Mapping[str, Numbers]]) -> dict[str, Numbers]:
    """Return the means over frames, by name and metric, metrics in the order of ``METRICS``."""
    lists: dict[str, dict[str, list[float]]] = {}
    for frame in frames:
        for name, numbers in frame.items():
            for key, value in numbers.items():
                lists.setdefault(name, {}).setdefault(key, []).append(value)
    return {
        name: {key: float(np.mean(numbers[key])) for key in METRICS if key in numbers}
        for name, numbers in lists.items()
    }


def with_left_over(numbers: Mapping[str, Numbers], left_over: Mapping[str, float]) -> dict[str, Numbers]:
    """Return numbers together with what motion leaves over, where it was measured."""
    more = {name: numbers[name] | {"left_over": value} for name, value in left_over.items()}
    return {**numbers, **mean_numbers([more])}


def _mean(rows: Iterable[Numbers]) -> Numbers:
    return mean_numbers({"": row} for row in rows).get("", {})


def _woven(volume: np.ndarray, given_deg: Sequence[float]) -> Numbers:
    """Return the grid index, or nothing for a volume that has no structure."""
    try:
        return {"grid_index": grid_index(volume, tuple(given_deg))}
    except ValueError:
        return {}

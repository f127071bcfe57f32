"""A tree of glowing wood and leaves, for Fig. 17: structures that a texture's histograms do not know."""

from collections.abc import Sequence

import numpy as np

GOLDEN_DEG = 137.5  # between one branch and the next
CROWN = (0.25, 0.9)  # heights of the lowest and the highest branch
SEEN = (0.3, 0.6)  # heights between which the trunk is looked for: inside of the crown
LEAF = 0.35  # density over that of wood


def tree(width: int = 48, height: int = 72, *, branches: int = 26, seed: int = 0) -> np.ndarray:
    """Return a tree, shape (x, z, y), whose brightest ray from the front is 255.

    Args:
        width: Of the box, and its depth [voxel].
        height: Of the box.
        branches: That leave the trunk; each has four twigs with leaves.
        seed: Of directions and lengths.
    """
    volume = np.zeros((width, width, height), np.float32)
    rng, path, thick = np.random.default_rng(seed), trunk(width, height), trunk_radius(width)
    for y in range(height - 2):
        _draw(volume, path[y], path[y + 1], thick * (1 - 0.7 * y / height))
    for number, part in enumerate(np.linspace(*CROWN, branches)):
        begin = path[int(part * height)]
        turn = np.deg2rad(GOLDEN_DEG * number + rng.uniform(-20, 20))
        length = width * (0.42 - 0.3 * part) * rng.uniform(0.8, 1.15)
        end = begin + length * np.array([np.cos(turn), np.sin(turn), rng.uniform(0.25, 0.6)])
        _draw(volume, begin, end, 0.45 * thick * (1.2 - part))
        for twig in range(4):
            fork = begin + (end - begin) * (0.45 + 0.18 * twig)
            tip = fork + 0.35 * length * rng.normal(0, 0.7, 3) + [0, 0, 0.1 * length]
            _draw(volume, fork, tip, 0.2 * thick)
            for leaf in tip + rng.normal(0, 0.05 * width, (5, 3)):
                _draw(volume, leaf, leaf, 0.4 * thick, LEAF)
    return volume * (255 / volume.sum(axis=1).max())


def trunk(width: int, height: int) -> np.ndarray:
    """Return where the middle of the trunk is at every height, (x, z, y), shape (height, 3)."""
    part = np.arange(height) / height
    middle = (width - 1) / 2
    x = middle + width * 0.07 * np.sin(4.0 * part + 0.4)
    z = middle + width * 0.06 * np.cos(5.0 * part)
    return np.stack([x, z, np.arange(height)], axis=1)


def trunk_radius(width: int) -> float:
    """Return the radius of the trunk at the floor."""
    return 0.032 * width


def trunk_contrast(views: np.ndarray, angles_deg: Sequence[float]) -> np.ndarray:
    """Measure how well the trunk can be told from what is beside it.

    Args:
        views: Of a tree, or of what was made of one, shape (angle, u, v).
        angles_deg: Their angles.

    Returns:
        The difference of the light on the trunk and beside it over the sum, for each view and height inside of the
        crown, shape (angle, height): 1 for a trunk before black, 0 where there is none.
    """
    _, width, height = views.shape
    path, radius = trunk(width, height), trunk_radius(width)
    rows = np.arange(int(SEEN[0] * height), int(SEEN[1] * height))
    pixels, found = np.arange(width), []
    for image, angle in zip(views, np.deg2rad(np.asarray(angles_deg, np.float64)), strict=True):
        x, z = path[rows, 0] - (width - 1) / 2, path[rows, 1] - (width - 1) / 2
        apart = np.abs(pixels[:, None] - (x * np.cos(angle) + z * np.sin(angle) + (width - 1) / 2))
        on, beside = apart <= max(radius, 1), (apart > 2 * radius + 0.5) & (apart <= 2 * radius + 3.5)
        light = [np.where(part, image[:, rows], 0).sum(axis=0) / part.sum(axis=0) for part in (on, beside)]
        found.append((light[0] - light[1]) / np.maximum(light[0] + light[1], 1e-6))
    return np.array(found)


def _draw(volume: np.ndarray, begin: np.ndarray, end: np.ndarray, radius: float, density: float = 1.0) -> None:
    """Draw a round stick into a volume, (x, z, y); its edge falls off over a voxel, and thin ones are fainter."""
    low = np.maximum(np.floor(np.minimum(begin, end) - radius - 1), 0).astype(int)
    high = np.minimum(np.ceil(np.maximum(begin, end) + radius + 2), volume.shape).astype(int)
    if (low >= high).any():
        return
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    at = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True)), indexing="ij"), axis=-1)
    along = end - begin
    part = np.clip((at - begin) @ along / max(along @ along, 1e-9), 0, 1)
    distance = np.linalg.norm(at - begin - part[..., None] * along, axis=-1)
    edge = np.clip(max(radius, 0.5) + 0.5 - distance, 0, 1) * min(1, (radius / 0.5) ** 2)
    np.maximum(volume[box], density * edge, out=volume[box])

"""Plumes that rise, for the tests of comparisons."""

from pathlib import Path

import numpy as np
from scipy import ndimage

from warpfluid.comparison.entries import Entry, make_entries
from warpfluid.files.npz import write_npz
from warpfluid.volumes import open_volumes

WIDTH, HEIGHT = 32, 40


def plume(frame: int = 0, seed: int = 0) -> np.ndarray:
    """Return wisps inside a cone that rise by a voxel a frame, shape (x, z, y), brightest ray of the front 255."""
    noise = np.random.default_rng(seed).standard_normal((WIDTH, WIDTH, HEIGHT + 16))
    wisps = sum(w * ndimage.gaussian_filter(noise, (g, g, 2 * g)) * g**2 for g, w in ((1, 1), (2, 1.5)))
    wisps = np.roll(wisps, frame, axis=2)[..., :HEIGHT]
    x = np.arange(WIDTH) - (WIDTH - 1) / 2
    inside = np.hypot(x[:, None], x)[..., None] / (WIDTH * 0.4 * np.linspace(1, 0.6, HEIGHT))
    volume = np.maximum(wisps - 1.2 * inside**2 + 0.3, 0)
    return (volume * (255 / volume.sum(axis=1).max())).astype(np.float32)


def blurred(volume: np.ndarray) -> np.ndarray:
    """Return the volume without its detail."""
    return ndimage.gaussian_filter(volume, 2)


def write(folder: Path, make, frames=range(1, 5), scale: float = 0.01) -> str:
    """Write a volume a frame, as another program would; return the folder's name."""
    folder.mkdir()
    for frame in frames:
        write_npz(folder / f"{folder.name}.{frame:04d}.npz", scale * make(frame).transpose(0, 2, 1))
    return str(folder)


def entries(*names: str) -> list[Entry]:
    """Open volumes."""
    return make_entries([open_volumes(name) for name in names])

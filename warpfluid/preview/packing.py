"""Volumes made small for a page: a byte a voxel, cut to what is lit, packed, and coarser if they must be.

A byte holds the square root of the density, so that faint smoke keeps its steps: with 255 levels up to the brightest
voxel of the whole sequence a ray sum is off by less than a grey level. Sums of light stay what they were when voxels
grow, for a coarse voxel is the mean of those it covers.
"""

import base64
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from warpfluid.volumes import VolumeSequence

LEVELS = 255
SAMPLES = 5  # frames that the size is estimated from
AIM = (0.8, 0.95)  # share of the budget between which an estimate will do
ATTEMPTS = 8  # at an estimate
SMALLEST_SIDE = 8  # voxels; below there is nothing to see
BASE64 = 4 / 3


@dataclass(frozen=True, kw_only=True)
class Extent:
    """What a sequence fills.

    Attributes:
        box: Its voxels (x, z, y).
        low: First voxel that is lit in any frame, with an empty one before it where there is room.
        high: One past the last, with an empty one after it.
        peak: Density of the brightest voxel.
        lights: Total density of every frame.
    """

    box: tuple[int, int, int]
    low: tuple[int, int, int]
    high: tuple[int, int, int]
    peak: float
    lights: tuple[float, ...]

    @property
    def size(self) -> tuple[int, int, int]:
        """Voxels between low and high (x, z, y)."""
        return tuple(b - a for a, b in zip(self.low, self.high, strict=True))

    def coarser(self, factor: float) -> tuple[int, int, int]:
        """Return how many voxels are stored if every one is ``factor`` times as long."""
        return tuple(max(1, round(n / factor)) for n in self.size)


def measure(volumes: VolumeSequence, frames: Sequence[int]) -> Extent:
    """Find what is lit in any frame.

    Raises:
        ValueError: If the frames have unlike sizes, or a file is damaged.
    """
    box, peak, lights, spans = None, 0.0, [], []
    for frame in frames:
        density = volumes.density(frame)
        if box not in (None, density.shape):
            raise ValueError(f"{volumes.name}: frame {frame} has {density.shape} voxels (x, z, y), the others {box}")
        box, peak = density.shape, max(peak, float(density.max()))
        lights.append(float(density.sum(dtype=np.float64)))
        lit = [np.flatnonzero(density.any(axis=other)) for other in ((1, 2), (0, 2), (0, 1))]
        spans += [[(places[0], places[-1] + 1) for places in lit]] if lights[-1] > 0 else []
    spans = np.array(spans or [[(0, 1)] * 3])
    low = np.maximum(spans[..., 0].min(axis=0) - 1, 0)
    high = np.minimum(spans[..., 1].max(axis=0) + 1, box)
    return Extent(box=box, low=tuple(low.tolist()), high=tuple(high.tolist()), peak=peak or 1.0, lights=tuple(lights))


def choose_size(volumes: VolumeSequence, frames: Sequence[int], extent: Extent, budget: float) -> tuple[int, int, int]:
    """Return how many voxels (x, z, y) to store so that all frames fit into a budget, going by a few of them.

    Args:
        volumes: The sequence.
        frames: Those that are stored.
        extent: What they fill.
        budget: Characters that the packed frames may take.

    Raises:
        ValueError: If they fit only so coarse that nothing is left to see.
    """
    sample = [frames[i] for i in np.linspace(0, len(frames) - 1, min(SAMPLES, len(frames))).round().astype(int)]
    factor, size = 1.0, extent.size
    for _ in range(ATTEMPTS):
        mean = np.mean([len(packed) for packed in pack(volumes, sample, extent, size)])
        share = float(mean) * len(frames) / max(budget, 1)
        if share <= AIM[1] and (factor == 1 or share >= AIM[0]):
            break
        factor = max(factor * (share / np.mean(AIM)) ** (1 / 3), 1.0)
        size = extent.coarser(factor)
    if max(size) < min(SMALLEST_SIDE, max(extent.size)):
        raise ValueError(
            f"{len(frames)} frames do not fit into {budget / 1e6:.2g} MB: choose fewer with --frames, or a larger "
            "--html-size"
        )
    return size


def pack_within(
    volumes: VolumeSequence, frames: Sequence[int], extent: Extent, budget: float
) -> tuple[tuple[int, int, int], list[str]]:
    """Return how many voxels (x, z, y) are stored, and the packed frames, which fit into a budget.

    Arguments and errors are those of ``choose_size``.
    """
    aim = budget
    while True:
        size = choose_size(volumes, frames, extent, aim)
        packed = list(pack(volumes, frames, extent, size))
        if sum(map(len, packed)) <= budget:
            return size, packed
        aim *= 0.9  # the frames between those that were tried are fuller


def pack(volumes: VolumeSequence, frames: Sequence[int], extent: Extent, size: tuple[int, int, int]) -> Iterator[str]:
    """Yield every frame as text: base64 of zlib of bytes (x, z, y), each less the one below it."""
    inside = tuple(slice(a, b) for a, b in zip(extent.low, extent.high, strict=True))
    for frame in frames:
        density = coarsen(volumes.density(frame)[inside], size)
        levels = np.rint(LEVELS * np.sqrt(density / np.float32(extent.peak))).astype(np.uint8)
        steps = np.diff(levels, axis=2, prepend=np.uint8(0))
        yield base64.b64encode(zlib.compress(np.ascontiguousarray(steps), 9)).decode()


def unpack(text: str, size: tuple[int, int, int], peak: float) -> np.ndarray:
    """Return the density that a page shows for a packed frame, shape (x, z, y)."""
    steps = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(size)
    levels = np.cumsum(steps, axis=2, dtype=np.uint8)
    return ((levels / np.float32(LEVELS)) ** 2 * np.float32(peak)).astype(np.float32)


def coarsen(volume: np.ndarray, size: tuple[int, int, int]) -> np.ndarray:
    """Return the means of a volume over larger voxels, which may begin and end within one."""
    for axis, count in enumerate(size):
        if count != volume.shape[axis]:
            volume = np.moveaxis(np.tensordot(_shares(volume.shape[axis], count), volume, (1, axis)), 0, axis)
    return volume


def _shares(fine: int, coarse: int) -> np.ndarray:
    """Return what share every fine voxel has in every coarse one, rows of sum 1, shape (coarse, fine)."""
    edges = np.arange(coarse + 1) * (fine / coarse)
    places = np.arange(fine)
    covered = np.minimum(edges[1:, None], places + 1) - np.maximum(edges[:-1, None], places)
    return (np.maximum(covered, 0) * (coarse / fine)).astype(np.float32)

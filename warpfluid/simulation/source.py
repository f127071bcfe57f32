"""What a simulation starts from and follows: a sequence of volumes, or an empty box."""

from dataclasses import dataclass

import numpy as np

from warpfluid.volumes import VolumeSequence, boxed

FULL = 0.99  # quantile of the density that counts as full
WIDE = 4.0  # heights of a box are this many widths of a usual plume
NOTHING = VolumeSequence(name="", files={})


@dataclass(frozen=True, kw_only=True)
class Source:
    """Volumes as they are simulated.

    Attributes:
        volumes: They, as they are on disk; none for an empty box.
        shape: Voxels of a volume (x, z, y), as deep as wide.
        resolution_scale: Voxels of the simulation for one of the source, along each axis.
        reference: Full density, in grey levels a voxel.
    """

    volumes: VolumeSequence = NOTHING
    shape: tuple[int, int, int]
    resolution_scale: float = 1.0
    reference: float = 1.0

    @property
    def frames(self) -> tuple[int, ...]:
        """Its frames, rising."""
        return self.volumes.frames

    def volume(self, frame: int) -> np.ndarray:
        """Return a volume in grey levels, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged, holds no density or has another size.
            OSError: If it cannot be read.
        """
        volume = boxed(_resample(self.volumes.density(frame), self.resolution_scale), self.shape)
        if volume is None:
            path = self.volumes.files[frame]
            raise ValueError(f"{path}: the volume is larger than that of frame {self.frames[0]}")
        return volume


def empty_box(size: tuple[int, int], resolution_scale: float = 1.0) -> Source:
    """Return a box of a width and height [voxel], as deep as wide, with nothing in it."""
    width, height = (max(4, round(n * resolution_scale)) for n in size)
    return Source(shape=(width, width, height), reference=WIDE * 255 / height)


def fill_box(volumes: VolumeSequence, resolution_scale: float = 1.0) -> Source:
    """Return volumes in a box that is as deep as wide.

    Raises:
        ValueError: If the first volume will not do.
        OSError: If it cannot be read.
    """
    first = _resample(volumes.density(volumes.frames[0]), resolution_scale)
    width, height = max(first.shape[:2]), first.shape[2]
    lit = first[first > 0]
    return Source(
        volumes=volumes,
        shape=(width, width, height),
        resolution_scale=resolution_scale,
        reference=float(np.quantile(lit, FULL)) if lit.size else WIDE * 255 / height,
    )


def _resample(volume: np.ndarray, factor: float) -> np.ndarray:
    """Return a volume with more or fewer voxels and the same ray sums."""
    if factor == 1:
        return volume
    from scipy.ndimage import zoom

    return np.maximum(zoom(volume, factor, order=1, mode="nearest", grid_mode=True), 0) / np.float32(factor)

"""Motion blur: the mean of pictures at moments while the shutter is open, the fluid carried along its velocity."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import warp as wp

from warpfluid.kernels.advection import advect
from warpfluid.rendering.picture import Picture


def moments(
    fields: Mapping[str, wp.array], velocity: tuple[wp.array, wp.array, wp.array], *, shutter: float, samples: int
) -> Iterator[dict[str, wp.array]]:
    """Carry fields to moments evenly around their frame.

    Args:
        fields: By name, shape (x, z, y).
        velocity: Along x, z and y [voxel/frame], of the same shape.
        shutter: How long it is open, half of it before the frame and half after [frame].
        samples: How many moments.

    Yields:
        The fields at each moment, the earliest first.

    Raises:
        ValueError: If the shutter or the number of samples makes no sense, or shapes do not fit.
    """
    if not (0 <= shutter < np.inf) or samples < 1:
        raise ValueError(f"shutter is {shutter} and samples {samples}; expected 0 or more, and at least 1")
    for i in range(samples):
        time = shutter * ((i + 0.5) / samples - 0.5)
        yield {name: advect(field, *velocity, time_step=time) if time else field for name, field in fields.items()}


def mean_picture(pictures: Iterable[Picture]) -> Picture:
    """Return the mean of pictures; the depth is the mean where there is something, weighted by how much.

    Raises:
        ValueError: If there is no picture.
    """
    count, sums, depth, weights = 0, None, 0.0, 0.0
    for picture in pictures:
        layers = (picture.color, picture.alpha, picture.density, picture.emission)
        sums = [0.0] * len(layers) if sums is None else sums
        sums = [total + layer.astype(np.float64) for total, layer in zip(sums, layers, strict=True)]
        weight = np.where(np.isfinite(picture.depth), picture.alpha + picture.color.mean(axis=2), 0.0)
        depth = depth + weight * np.where(weight > 0, picture.depth, 0)
        weights = weights + weight
        count += 1
    if not count:
        raise ValueError("pictures are none; at least one is needed")
    color, alpha, density, emission = ((total / count).astype(np.float32) for total in sums)
    depth = np.where(weights > 0, depth / np.maximum(weights, 1e-30), np.inf).astype(np.float32)
    return Picture(color, alpha, depth, density, emission)

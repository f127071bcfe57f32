"""Where a fluid has come apart from the volume that it is drawn to, and how much faster it is drawn there.

Half of one filament and half of another, elsewhere, are haze. What agrees may be mixed slowly, what does not is soon
to be one or the other.
"""

import warp as wp

from warpfluid.kernels import checks
from warpfluid.kernels.blur import blur
from warpfluid.kernels.launch import elementwise

SMOOTHING = 2.0  # over which fields are compared [voxel]
LOW, HIGH = 0.1, 0.4  # disagreements at which density begins to be drawn faster, and from which on it is fastest

wp.set_module_options({"enable_backward": False})


@wp.kernel
def difference_kernel(a: wp.array[float], b: wp.array[float], out: wp.array[float]):
    """How far two fields are apart."""
    i = wp.tid()
    out[i] = wp.abs(a[i] - b[i])


@wp.kernel
def quicken_kernel(
    difference: wp.array[float],
    a: wp.array[float],
    b: wp.array[float],
    low: float,
    high: float,
    factor: float,
    amounts: float,
    out: wp.array[float],
):
    """Multiply by up to a factor where smoothed fields disagree."""
    i = wp.tid()
    both = wp.max(a[i] + b[i], 1.0e-9)
    apart = (difference[i] - (1.0 - amounts) * wp.abs(a[i] - b[i])) / both
    t = wp.clamp((apart - low) / (high - low), 0.0, 1.0)
    out[i] = wp.min(out[i] * (1.0 + (factor - 1.0) * t * t * (3.0 - 2.0 * t)), 1.0)


def quicken(
    share: wp.array3d[float],
    density: wp.array3d[float],
    volume: wp.array3d[float],
    *,
    factor: float,
    amounts: bool = True,
) -> wp.array3d[float]:
    """Take a larger share of a volume where a density disagrees with it, in place.

    Disagreement is the mean difference about a voxel over the mean sum: 0 for equal fields, 1 where one is empty.

    Args:
        share: What is taken of the volume, 0 to 1, shape (x, z, y).
        density: What is drawn to the volume, the same shape.
        volume: The same shape.
        factor: Of the share where they disagree most; it ends at 1.
        amounts: Count that one of them has more light than the other; without, only detail that lies elsewhere counts.

    Returns:
        ``share``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    checks.same_device(share=share, density=density, volume=volume)
    checks.floats(3, share=share, density=density, volume=volume)
    checks.same_shape(share=share, density=density, volume=volume)
    difference = elementwise(difference_kernel, [density, volume], wp.empty_like(density))
    smooth = [blur(field, SMOOTHING) for field in (difference, density, volume)]
    return elementwise(quicken_kernel, [*smooth, LOW, HIGH, factor, float(amounts)], share)

"""What obstacles keep from the volumes that are followed: matter that would have had to pass through them.

The volumes know of no obstacle, and show as much light behind it as ever. A fluid that is drawn to them would be made
anew there. So what a volume shows counts less where the footage's own motion leads back into a solid.
"""

import math

import warp as wp

from warpfluid.kernels import vectors
from warpfluid.kernels.sides import SIX
from warpfluid.simulation.solids import clear
from warpfluid.simulation.state import Faces, Solids
from warpfluid.simulation.transport import advect_scalar

MOST_STEPS = 16  # a frame; with steps of a voxel no thin slab is jumped over


def advance_shadow(
    shadow: wp.array | None, motion: Faces, solids: Solids | None, sides: SIX, seconds: float, *, keep: float
) -> wp.array | None:
    """Return the share of the footage's matter that solids keep from each voxel, after a frame.

    Args:
        shadow: Before it, 0 to 1, shape (x, z, y); None where there was none.
        motion: What the footage asks for [voxel/s].
        solids: What stands in the way; None for nothing.
        sides: What the sides of the box are.
        seconds: How long the frame lasts.
        keep: Share that is not forgotten, 0 to 1.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    if shadow is None and solids is None:
        return None
    if shadow is None:
        shadow = wp.zeros_like(solids.fluid)
    speed = max(vectors.largest(part) for part in motion)
    steps = min(max(math.ceil(speed * seconds), 1), MOST_STEPS)
    shadow = _beside(shadow, solids)
    for _ in range(steps):
        shadow = advect_scalar(shadow, motion, sides, seconds / steps, scheme="semi-lagrangian")
        shadow = _beside(shadow, solids)
    nothing = wp.zeros_like(shadow)
    return vectors.add_scaled(nothing, keep, shadow, out=nothing)


def shaded(volume: wp.array, shadow: wp.array) -> wp.array:
    """Return what is left of a volume in a shadow, both of shape (x, z, y)."""
    lit = _rest(shadow)
    return vectors.multiply(lit, volume, out=lit)


def _beside(shadow: wp.array, solids: Solids | None) -> wp.array:
    """Return a shadow that is whole inside solids."""
    if solids is None:
        return shadow
    lit = _rest(shadow)
    clear(lit, solids)
    return _rest(lit)


def _rest(share: wp.array) -> wp.array:
    """Return one less a share."""
    one = wp.full_like(share, 1.0)
    return vectors.add_scaled(one, -1.0, share, out=one)

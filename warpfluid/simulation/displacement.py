"""Where an edit has carried matter: the way from where the footage alone would have it.

Blending a volume into a fluid that has gone another way mixes detail that disagrees, and blurs. So an edited fluid is
not drawn to the volume but to the volume moved to where the edit has carried it.
"""

import numpy as np
import warp as wp

from warpfluid.kernels.advection import advect
from warpfluid.kernels.blur import blur
from warpfluid.kernels.sides import SIX
from warpfluid.simulation.state import Faces
from warpfluid.simulation.transport import advect_scalars
from warpfluid.simulation.written import centred

SMOOTHING = 2.0  # of the way [voxel]: finer eddies fold it, and a folded volume is ragged

Displacement = tuple[wp.array, wp.array, wp.array]


def advance_displacement(
    away: Displacement | None, velocity: Faces, asked: Faces, sides: SIX, seconds: float, *, keep: float
) -> Displacement:
    """Return how far matter has been carried after a frame.

    Args:
        away: Before it, along x, z and y, shapes (x, z, y) [voxel]; None at the start.
        velocity: Of the fluid [voxel/s].
        asked: What the footage asks for [voxel/s].
        sides: What the sides of the box are.
        seconds: How long the frame lasts.
        keep: Share that is not forgotten.
    """
    extra = centred(Faces(*(a.numpy() - b.numpy() for a, b in zip(velocity, asked, strict=True))))
    moved = (0.0, 0.0, 0.0)
    if away:
        moved = [a.numpy() for a in advect_scalars(list(away), velocity, sides, seconds, scheme="semi-lagrangian")]
    parts = (np.float32(keep) * (m + np.float32(seconds) * e) for m, e in zip(moved, extra, strict=True))
    return tuple(wp.array(part, dtype=float, device=velocity.x.device) for part in parts)


def displaced(volume: wp.array, away: Displacement) -> wp.array:
    """Return a volume, shape (x, z, y), moved as far as an edit has carried matter."""
    return advect(volume, *(blur(part, SMOOTHING) for part in away))

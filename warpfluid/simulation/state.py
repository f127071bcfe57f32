"""What a simulated fluid is at one moment.

Velocity lives on the faces between voxels (a MAC grid, Harlow and Welch 1965): face i lies between voxels i - 1 and i,
so there is one more along its own axis. Everything else lives in the voxels' centres.
"""

from dataclasses import dataclass
from typing import NamedTuple

import warp as wp

from warpfluid.kernels.sides import CLOSED, OPEN, SIX, WRAP

CELLS = ("density", "temperature", "fuel", "flame")  # what a fluid has in the voxels' centres
KINDS = {
    "open": (OPEN, OPEN),
    "closed": (CLOSED, CLOSED),
    "closed-low": (CLOSED, OPEN),
    "closed-high": (OPEN, CLOSED),
    "wrap": (WRAP, WRAP),
}


class Faces(NamedTuple):
    """A vector field on the faces of a grid of (nx, nz, ny) voxels.

    Attributes:
        x: Component along x, shape (nx + 1, nz, ny).
        z: Along z, shape (nx, nz + 1, ny).
        y: Along y, up, shape (nx, nz, ny + 1).
    """

    x: wp.array
    z: wp.array
    y: wp.array

    @classmethod
    def zeros(cls, shape: tuple[int, int, int], device: wp.Device) -> "Faces":
        """Return a field at rest for a grid of (x, z, y) voxels."""
        return cls(*(wp.zeros(face_shape(shape, axis), dtype=float, device=device) for axis in range(3)))


@dataclass(frozen=True, eq=False)
class Solids:
    """What stands in the fluid, as shares of faces and voxels (Batty, Bertails and Bridson 2007).

    Never changed once made, arrays included, so that what is worked out of it can be kept: what moves is made anew.

    Attributes:
        open: Share of each face that is fluid, 0 to 1.
        velocity: Of the solid at each face [voxel/s].
        fluid: Share of each voxel that is fluid, 0 to 1, shape (x, z, y).
    """

    open: Faces
    velocity: Faces
    fluid: wp.array


@dataclass
class FluidState:
    """A fluid at one moment.

    Attributes:
        velocity: [voxel/s].
        density: Shape (x, z, y); a ray's sum is a pixel value.
        temperature: 1 is as hot as what an emitter of temperature 1 lets in; the surroundings are 0.
        fuel: What may burn, in the unit of density.
        flame: Fuel that burnt lately, to be shown as light.
        phase: How far the pattern of the turbulence has moved on.
        seconds: Time since the start.
        away: How far edits have carried matter (``displacement.py``) [voxel].
        shadow: Share of the footage's matter that obstacles keep out (``shadow.py``), shape (x, z, y).
    """

    velocity: Faces
    density: wp.array
    temperature: wp.array
    fuel: wp.array
    flame: wp.array
    seconds: float = 0.0
    phase: float = 0.0
    away: tuple[wp.array, wp.array, wp.array] | None = None
    shadow: wp.array | None = None


def face_shape(shape: tuple[int, int, int], axis: int) -> tuple[int, int, int]:
    """Return the shape of the faces along an axis (0 is x, 1 is z, 2 is y) of a grid of (x, z, y) voxels."""
    return tuple(n + (k == axis) for k, n in enumerate(shape))


def six_sides(x: str, z: str, y: str) -> SIX:
    """Return what the sides are, for kernels; each argument is one of ``KINDS``."""
    return SIX(*KINDS[x], *KINDS[z], *KINDS[y])

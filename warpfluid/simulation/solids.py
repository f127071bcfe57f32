"""What stands in the fluid: which faces shapes close, how they move, and what must be true at them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import warp as wp

from warpfluid.kernels.fluid import shapes
from warpfluid.kernels.poisson import shares
from warpfluid.kernels.sides import SIX, WRAP
from warpfluid.simulation.placed import SWAP, Index, Placed, signed_distance
from warpfluid.simulation.shapes import Plane
from warpfluid.simulation.state import Faces, Solids, face_shape

BAND = 3.0  # voxels around a mesh where its distance is exact; only the nearest corners matter


def build_solids(
    placed: Sequence[Placed], shape: tuple[int, int, int], device: wp.Device, *, sides: SIX | None = None
) -> Solids:
    """Cut shapes out of a grid.

    Args:
        placed: The shapes; they may overlap and reach beyond the grid.
        shape: Voxels of the grid (x, z, y).
        device: Where to compute.
        sides: What the six sides of the grid are; a shape that leaves through a side that wraps comes in across.

    Returns:
        The shares of faces and voxels that are fluid, and the velocity of the nearest shape at the faces around shapes.
    """
    placed = [copy for solid in placed for copy in _copies(solid, shape, sides)]
    opening = Faces(*(wp.full(face_shape(shape, axis), 1.0, dtype=float, device=device) for axis in range(3)))
    fluid = wp.full(shape, 1.0, dtype=float, device=device)
    blocks = [block for solid in placed if (block := solid.block(shape))]
    for first, size in blocks:
        corner = tuple(n - 0.5 for n in first)
        corners = signed_distance(placed, tuple(n + 1 for n in size), device, first=corner, band=BAND)
        shares.voxel_share(corners, first=first, out=fluid)
        for axis in range(3):
            shares.face_share(corners, axis=axis, first=first, out=opening[axis])
    velocity = Faces.zeros(shape, device)
    if any(solid.moves for solid in placed):
        for block in blocks:
            _take_velocity(placed, *block, velocity)
    return Solids(opening, velocity, fluid)


def enforce(velocity: Faces, solids: Solids) -> None:
    """Give faces that a solid covers wholly its velocity, in place.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    for component, opening, solid in zip(velocity, solids.open, solids.velocity, strict=True):
        shares.hold(component, opening, solid)


def clear(field: wp.array, solids: Solids) -> None:
    """Empty what solids cover, in place.

    Voxels that are half fluid or more keep all they hold, for they are cleared again each step and would lose
    it little by little; from there to no fluid at all it falls to 0.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    shares.empty_covered(field, solids.fluid)


def _copies(solid: Placed, shape: tuple[int, int, int], sides: SIX | None) -> list[Placed]:
    """Return a shape and, where sides wrap, its copies one grid further that reach into the grid."""
    if sides is None or isinstance(solid.shape, Plane):
        return [solid]
    reach = [(-n, 0, n) if sides[2 * axis] == WRAP else (0,) for axis, n in enumerate(shape)]
    moved = [replace(solid, centre=solid.centre + SWAP @ shift) for shift in product(*reach)]
    return [copy for copy in moved if copy.block(shape)]


def _take_velocity(placed: Sequence[Placed], first: Index, size: Index, velocity: Faces) -> None:
    """Write the nearest shape's velocity at the faces of a block."""
    for axis, component in enumerate(velocity):
        nearest = wp.full(face_shape(size, axis), shapes.FAR, dtype=float, device=component.device)
        for solid in placed:
            shapes.nearest_velocity(
                solid.for_kernels(component.device, BAND),
                axis=axis,
                first=first,
                nearest=nearest,
                velocity=component,
                alone=len(placed) == 1,
            )

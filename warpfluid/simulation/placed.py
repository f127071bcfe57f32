"""Shapes where they are, and how they move: for solids, emitters and rigid bodies.

Turning needs right-handed axes, so points and vectors are (x, y, z) here, y up, in voxels from the centre of the first
voxel; the floor of the box is at y = -0.5. Grids and kernels speak (x, z, y); this file translates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import warp as wp

from warpfluid.kernels.fluid import shapes
from warpfluid.simulation.shapes import EVERYWHERE, Mesh, Shape

Index = tuple[int, int, int]
SWAP = np.eye(3)[[0, 2, 1]]  # between (x, y, z) and (x, z, y)


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape where it is, and how it moves.

    Attributes:
        shape: What it is.
        centre: Where its middle is (x, y, z) [voxel].
        rotation: Turns its own axes into those of the scene, shape (3, 3).
        velocity: (x, y, z) [voxel/s].
        spin: Angular velocity about the axes x, y and z [radian/s].

    Raises:
        ValueError: If an extent is not positive, or ``rotation`` is none.
    """

    shape: Shape
    centre: Sequence[float] = (0.0, 0.0, 0.0)
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: Sequence[float] = (0.0, 0.0, 0.0)
    spin: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self):
        if not min(self.shape.half_size) > 0 or not np.isfinite(self.shape.half_size).all():
            raise ValueError(f"{self.shape} has an extent that is not positive")
        for name in ("centre", "velocity", "spin"):
            value = np.asarray(getattr(self, name), np.float64)
            if value.shape != (3,) or not np.isfinite(value).all():
                raise ValueError(f"{name} is {getattr(self, name)}, expected three finite numbers (x, y, z)")
            object.__setattr__(self, name, value)
        rotation = np.asarray(self.rotation, np.float64)
        proper = rotation.shape == (3, 3) and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        if not proper or np.linalg.det(rotation) < 0:
            raise ValueError(f"rotation is {self.rotation}, expected a rotation matrix: rotation_of_degrees makes one")
        object.__setattr__(self, "rotation", rotation)

    @property
    def moves(self) -> bool:
        """Whether any part of it has a velocity."""
        return bool(np.any(self.velocity) or np.any(self.spin))

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and highest index coordinates (x, z, y) of the box that holds it."""
        reach = np.abs(self.rotation) @ self.shape.half_size
        return SWAP @ (self.centre - reach), SWAP @ (self.centre + reach)

    def block(self, shape: tuple[int, int, int], *, margin: int = 1) -> tuple[Index, Index] | None:
        """Return the first voxel and the size (x, z, y) of the part of a grid that holds it, None if it is outside."""
        low, high = self.bounds()
        first = np.clip(np.floor(low + 0.5) - margin, 0, shape)
        size = np.clip(np.ceil(high + 0.5) + margin, 0, shape) - first
        return (tuple(map(int, first)), tuple(map(int, size))) if size.min() > 0 else None

    def for_kernels(self, device: wp.Device, band: float) -> shapes.PlacedShape:
        """Return what kernels need to know, in index coordinates (x, z, y)."""
        placed = shapes.PlacedShape()
        wx, wy, wz = self.spin
        turning = np.array([[0, -wz, wy], [wz, 0, -wx], [-wy, wx, 0]])
        placed.kind = self.shape.kind
        placed.size = wp.vec3(*self.shape.half_size)
        placed.centre = wp.vec3(*(SWAP @ self.centre))
        placed.to_local = wp.mat33(*(self.rotation.T @ SWAP).flat)
        placed.velocity = wp.vec3(*(SWAP @ self.velocity))
        placed.turning = wp.mat33(*(SWAP @ turning @ SWAP).flat)
        placed.band = min(band, EVERYWHERE)
        if isinstance(self.shape, Mesh):
            placed.mesh = self.shape.on(device).id
        return placed


def rotation_of_degrees(degrees: Sequence[float]) -> np.ndarray:
    """Return the rotation about x, then y, then z, the order that Maya and Blender start with [degree]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()


def signed_distance(
    solids: Sequence[Placed],
    shape: tuple[int, int, int],
    device: wp.Device,
    *,
    first: tuple[float, float, float] = (0.0, 0.0, 0.0),
    band: float = EVERYWHERE,
) -> wp.array:
    """Measure the distance to the nearest of some shapes on a lattice.

    Args:
        solids: The shapes; without any the distance is a million.
        shape: Points of the lattice (x, z, y), a voxel apart.
        device: Where to compute.
        first: Index coordinates (x, z, y) of the first point: 0 for voxels' centres, -0.5 for their corners.
        band: Voxels from a mesh's bounds within which the distance is exact; beyond, it is that to the bounds.

    Returns:
        The distance [voxel], negative inside, of the lattice's shape.
    """
    out = wp.full(shape, shapes.FAR, dtype=float, device=device)
    for solid in solids:
        shapes.unite(solid.for_kernels(device, band), first=first, out=out)
    return out

"""Shapes around their own middle, in voxels, axes (x, y, z), y up."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import warp as wp

from warpfluid.kernels.fluid import shapes
from warpfluid.simulation.triangles import check_closed, weigh

EVERYWHERE = float(shapes.FAR)


@dataclass(frozen=True)
class Sphere:
    """A ball.

    Attributes:
        radius: [voxel].
    """

    radius: float
    kind: ClassVar[int] = shapes.SPHERE

    @property
    def volume(self) -> float:
        """[voxel^3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    @property
    def half_size(self) -> tuple[float, float, float]:
        """Half its extents [voxel]."""
        return (self.radius,) * 3


@dataclass(frozen=True)
class Box:
    """A box around its middle.

    Attributes:
        size: Its edges (x, y, z) [voxel].
    """

    size: tuple[float, float, float]
    kind: ClassVar[int] = shapes.BOX

    @property
    def volume(self) -> float:
        """[voxel^3]."""
        return float(np.prod(self.size))

    @property
    def half_size(self) -> tuple[float, float, float]:
        """Half its extents [voxel]."""
        return tuple(0.5 * edge for edge in self.size)


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder around its middle.

    Attributes:
        radius: [voxel].
        height: [voxel].
    """

    radius: float
    height: float
    kind: ClassVar[int] = shapes.CYLINDER

    @property
    def volume(self) -> float:
        """[voxel^3]."""
        return np.pi * self.radius**2 * self.height

    @property
    def half_size(self) -> tuple[float, float, float]:
        """Half its extents [voxel]."""
        return (self.radius, 0.5 * self.height, self.radius)


@dataclass(frozen=True)
class Plane:
    """Level ground: everything below it is inside."""

    half_size: ClassVar[tuple[float, float, float]] = (EVERYWHERE,) * 3
    volume: ClassVar[float] = np.inf
    kind: ClassVar[int] = shapes.PLANE


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface of triangles around the origin.

    Attributes:
        vertices: [voxel], shape (n, 3).
        triangles: Indices of vertices, shape (m, 3); turned around if they look inwards.

    Raises:
        ValueError: If the surface is not closed.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    kind: ClassVar[int] = shapes.MESH
    _loaded: dict[str, wp.Mesh] = field(default_factory=dict, repr=False)

    def __post_init__(self):
        vertices, triangles = np.array(self.vertices, np.float32), np.array(self.triangles, np.int32)
        check_closed(vertices, triangles)
        triangles = triangles[:, ::-1] if weigh(vertices, triangles).volume < 0 else triangles
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", np.ascontiguousarray(triangles))

    @property
    def half_size(self) -> tuple[float, float, float]:
        """Half the extents of the box around the origin that holds it [voxel]."""
        return tuple(float(reach) for reach in np.abs(self.vertices).max(axis=0))

    @property
    def volume(self) -> float:
        """[voxel^3]."""
        return weigh(self.vertices, self.triangles).volume

    def on(self, device: wp.Device) -> wp.Mesh:
        """Return the mesh in a device's memory, with its search tree."""
        if str(device) not in self._loaded:
            points = wp.array(self.vertices, dtype=wp.vec3, device=device)
            indices = wp.array(self.triangles.reshape(-1), dtype=int, device=device)
            self._loaded[str(device)] = wp.Mesh(points, indices, support_winding_number=True)
        return self._loaded[str(device)]


Shape = Sphere | Box | Cylinder | Plane | Mesh

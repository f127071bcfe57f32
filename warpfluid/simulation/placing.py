"""From what an artist says, in tenths of the box's height, to voxels and seconds."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpfluid.files.mesh import read_mesh
from warpfluid.options import BodyOptions, EmitterOptions, ObstacleOptions
from warpfluid.options.keys import Keyed
from warpfluid.simulation.emitters import Emitter
from warpfluid.simulation.placed import Placed, rotation_of_degrees
from warpfluid.simulation.rigid_body import RigidBody
from warpfluid.simulation.shapes import Box, Cylinder, Mesh, Sphere

UNITS = 10.0  # in the height of a box


@dataclass(frozen=True)
class Placing:
    """The lattice of a simulation, and what full density is.

    Attributes:
        shape: Voxels (x, z, y).
        reference: Full density, in the unit of the volumes.
    """

    shape: tuple[int, int, int]
    reference: float

    @property
    def unit(self) -> float:
        """A tenth of the box's height [voxel]."""
        return self.shape[2] / UNITS

    @property
    def origin(self) -> np.ndarray:
        """The middle of the floor (x, y, z), from the centre of voxel (0, 0, 0) [voxel]."""
        return np.array([(self.shape[0] - 1) / 2, -0.5, (self.shape[1] - 1) / 2])

    def point(self, text: str, frame: float) -> np.ndarray:
        """Return a position at a frame (x, y, z) [voxel]."""
        return self.origin + self.unit * Keyed(text, 3).at(frame)

    def vector(self, text: str, frame: float) -> np.ndarray:
        """Return a length, velocity or acceleration at a frame (x, y, z) [voxel]."""
        return self.unit * Keyed(text, 3).at(frame)

    def emitter(self, options: EmitterOptions, frame: float) -> Emitter:
        """Return an emitter as it is at a frame."""
        at = lambda value: Keyed(value).at(frame)  # noqa: E731
        return Emitter(
            placed=self.solid(options, frame, frame),
            soft_edge=at(options.soft_edge) * self.unit,
            density=at(options.density) * self.reference,
            fuel=at(options.fuel) * self.reference,
            temperature=at(options.temperature),
            velocity=tuple(self.vector(options.velocity, frame)),
            velocity_rate=at(options.drive),
            noise=at(options.noise),
            noise_frequency=options.noise_frequency / self.unit,
            noise_speed=options.noise_speed,
            seed=options.seed,
        )

    def solid(
        self, options: EmitterOptions | ObstacleOptions, frame: float, later: float, seconds: float = 1.0
    ) -> Placed:
        """Return a shape at a frame, on its way to where it will be ``seconds`` later."""
        centre = self.point(options.center, frame)
        velocity = (self.point(options.center, later) - centre) / seconds
        rotation = rotation_of_degrees(Keyed(options.rotation, 3).at(frame))
        return Placed(self._shape(options, frame), centre, rotation, velocity)

    def body(self, options: BodyOptions, frame: float) -> RigidBody:
        """Return a rigid body as it starts."""
        return RigidBody(
            self._shape(options, frame),
            position=self.point(options.center, frame),
            rotation=rotation_of_degrees(Keyed(options.rotation, 3).at(frame)),
            velocity=self.vector(options.velocity, frame),
            spin=np.deg2rad(Keyed(options.spin, 3).at(frame)),
            mass_density=options.weight,
            coupling=options.carry,
            restitution=options.restitution,
            friction=options.friction,
        )

    def _shape(self, options, frame: float):
        size = self.unit * Keyed(options.size, 3).at(frame)
        if options.shape == "mesh":
            return self._mesh(options, size)
        if options.shape == "box":
            return Box(tuple(size))
        radius = self.unit * Keyed(options.radius).at(frame)
        return Sphere(radius) if options.shape == "sphere" else Cylinder(radius, size[1])

    def _mesh(self, options, size: np.ndarray) -> Mesh:
        """Return a mesh about the middle of its box, as large as ``size`` says."""
        if options.mesh is None:
            raise ValueError("a shape is mesh, but no file is named: add mesh=FILE")
        vertices, triangles = read_mesh(Path(options.mesh))
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        return Mesh(((vertices - (low + high) / 2) * (size.max() / (high - low).max())).astype(np.float32), triangles)

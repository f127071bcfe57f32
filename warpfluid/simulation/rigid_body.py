"""Rigid bodies that fall, bounce, slide and are carried by the fluid, as the car in Fig. 12c is.

Points and vectors are (x, y, z), y up, in voxels from the centre of the first voxel, as in ``placed.py``.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from warpfluid.simulation.placed import Placed
from warpfluid.simulation.shapes import Box, Mesh
from warpfluid.simulation.triangles import box_surface, cover, weigh

SURFACE_POINTS = 200
STANDOFF = 1.5  # voxels outside of the surface, where the flow is no longer the body's own


class RigidBody:
    """A body, where it is and how it moves.

    Args:
        shape: Box or mesh; a mesh is moved so that its centre of mass is its middle.
        position: Of the centre of mass (x, y, z) [voxel].
        rotation: From its axes to those of the scene, shape (3, 3).
        velocity: (x, y, z) [voxel/s].
        spin: Angular velocity [radian/s].
        mass_density: How heavy it is: one of 2 follows the flow half as fast.
        coupling: How fast fluid of the reference density carries along a body of mass density 1 [1/s].
        restitution: Share of the speed that a bounce gives back, 0 to 1.
        friction: Coulomb's coefficient.

    Attributes:
        position: Of the centre of mass [voxel].
        quaternion: Its orientation, (x, y, z, w).
        velocity: [voxel/s].
        spin: [radian/s].
        asleep: Whether it lies still until something pushes it.
        still: For how long it has hardly moved [s].
        hull: The corners that it can stand on, from its centre of mass along its own axes, shape (n, 3).
        points: Where it feels the flow, as the hull, shape (p, 3).
        shares: Of the surface that belong to these points, shape (p,).
        mass: Mass density times volume.

    Raises:
        ValueError: If a number makes no sense.
    """

    def __init__(
        self,
        shape: Box | Mesh,
        *,
        position: Sequence[float],
        rotation: np.ndarray | None = None,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        spin: Sequence[float] = (0.0, 0.0, 0.0),
        mass_density: float = 1.0,
        coupling: float = 1.0,
        restitution: float = 0.3,
        friction: float = 0.5,
    ):
        if not (mass_density > 0 and 0 <= restitution <= 1 and friction >= 0 and 0 <= coupling < np.inf):
            raise ValueError("a body needs mass_density > 0, restitution 0 to 1, friction >= 0, coupling >= 0")
        if not isinstance(shape, Box | Mesh):
            raise ValueError(f"a body's shape is {type(shape).__name__}, expected a Box or a Mesh, which have corners")
        box = isinstance(shape, Box)
        vertices, self.triangles = box_surface(shape.size) if box else (shape.vertices, shape.triangles)
        volume, centre, inertia = weigh(vertices, self.triangles)
        self.vertices = vertices - centre
        self.shape = shape if box else Mesh(self.vertices, self.triangles)
        placed = Placed(self.shape, position, np.eye(3) if rotation is None else rotation, velocity, spin)
        self.position, self.velocity, self.spin = placed.centre, placed.velocity, placed.spin
        self.quaternion = Rotation.from_matrix(placed.rotation).as_quat()
        self.mass, self.volume, self.inertia = mass_density * volume, volume, mass_density * inertia
        self.coupling, self.restitution, self.friction = coupling, restitution, friction
        self.asleep, self.still = False, 0.0
        self.hull = self.vertices[ConvexHull(self.vertices).vertices]
        points, normals, self.shares = cover(self.vertices, self.triangles, SURFACE_POINTS)
        self.points = points + STANDOFF * normals

    @property
    def rotation(self) -> np.ndarray:
        """From its own axes to those of the scene, shape (3, 3)."""
        return Rotation.from_quat(self.quaternion).as_matrix()

    @property
    def energy(self) -> float:
        """Kinetic energy, of motion and of turning."""
        return float(
            0.5 * self.mass * self.velocity @ self.velocity + 0.5 * self.spin @ self.turned_inertia() @ self.spin
        )

    def placed(self) -> Placed:
        """Return it as an obstacle for the fluid."""
        return Placed(self.shape, self.position, self.rotation, self.velocity, self.spin)

    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Return its vertices where they are, (n, 3) [voxel], and its triangles, (m, 3)."""
        return self.vertices @ self.rotation.T + self.position, self.triangles

    def state(self) -> dict[str, np.ndarray]:
        """Return all that changes, as arrays by name."""
        names = ("position", "quaternion", "velocity", "spin")
        return {name: getattr(self, name).copy() for name in names} | {"rest": np.array([self.asleep, self.still])}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take back what ``state`` returned."""
        for name in ("position", "quaternion", "velocity", "spin"):
            setattr(self, name, np.array(state[name], np.float64))
        self.asleep, self.still = bool(state["rest"][0]), float(state["rest"][1])

    def turned_inertia(self) -> np.ndarray:
        """Inertia about the axes of the scene."""
        rotation = self.rotation
        return rotation @ self.inertia @ rotation.T

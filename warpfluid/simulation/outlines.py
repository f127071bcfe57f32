"""The surfaces of what stands in a simulated run: its obstacles and rigid bodies, frame by frame, to be drawn."""

from typing import NamedTuple

import numpy as np

from warpfluid.options.scene import make_thing
from warpfluid.run import Run
from warpfluid.simulation.placed import Placed
from warpfluid.simulation.placing import Placing
from warpfluid.simulation.recorded import RecordedBodies
from warpfluid.simulation.shapes import Box, Mesh, Sphere
from warpfluid.simulation.triangles import box_surface, turned_surface

ROUND = 32  # rings of a ball


class Outline(NamedTuple):
    """A closed surface.

    Attributes:
        vertices: Index coordinates (x, y, z) [voxel], shape (n, 3).
        triangles: Indices, anticlockwise seen from outside, shape (m, 3).
        kind: ``body`` or ``obstacle``.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    kind: str


class Outlines:
    """What stands in a run.

    Args:
        run: The run; one that is no simulation has nothing in it.

    Raises:
        ValueError: If its settings or its bodies are damaged.
        OSError: If they cannot be read.
    """

    def __init__(self, run: Run):
        self._settings = run.settings()
        tables = self._settings.get("obstacle", ())
        self._obstacles = [make_thing("obstacle", table, where="run.toml: [[obstacle]] ") for table in tables]
        self._bodies = RecordedBodies(self._settings, run.folder)

    def at(self, frame: int, shape: tuple[int, int, int]) -> list[Outline]:
        """Return the surfaces at a frame.

        Args:
            frame: Its number.
            shape: Of the run's volumes (x, z, y).

        Raises:
            ValueError: If a mesh is damaged or the bodies do not fit the settings.
            OSError: If a mesh cannot be read.
        """
        placing = Placing(tuple(shape), 1.0)
        found = [Outline(*_surface(placing.solid(options, frame, frame)), "obstacle") for options in self._obstacles]
        states = self._bodies.states.get(frame, ())
        voxel = self._settings.get("output", {}).get("voxel_size", 1.0)
        voxel /= self._settings.get("simulate", {}).get("detail", 1)  # its files have more and smaller voxels
        for body, state in zip(self._bodies.place(shape, frame) if states else (), states, strict=True):
            body.position = placing.origin + state["position"] / voxel
            body.quaternion = state["quaternion"]
            found.append(Outline(*body.surface(), "body"))
        return found


def _surface(placed: Placed) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and triangles of a shape where it is."""
    shape = placed.shape
    if isinstance(shape, Mesh):
        vertices, triangles = shape.vertices, shape.triangles
    elif isinstance(shape, Box):
        vertices, triangles = box_surface(np.asarray(shape.size))
    elif isinstance(shape, Sphere):
        angles = np.linspace(-np.pi / 2, np.pi / 2, ROUND + 1)[1:-1]
        ends = (-shape.radius, shape.radius)
        vertices, triangles = turned_surface(shape.radius * np.cos(angles), shape.radius * np.sin(angles), ends)
    else:
        half = shape.height / 2
        vertices, triangles = turned_surface(np.full(2, shape.radius), np.array([-half, half]), (-half, half))
    return vertices @ placed.rotation.T + placed.centre, triangles

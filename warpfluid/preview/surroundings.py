"""What stands about a run's volumes: the footage they were made from, bodies and obstacles."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from warpfluid.files.bodies import read_bodies
from warpfluid.files.sequences import format_frames
from warpfluid.footage.shot import Shot, open_shot
from warpfluid.options import InputOptions
from warpfluid.options.scene import make_thing
from warpfluid.preview.scene import Scene
from warpfluid.run import BODIES, SETTINGS, Run


class Solid(NamedTuple):
    """A surface of flat triangles in a volume.

    Attributes:
        vertices: Index coordinates (x, y, z) [voxel], shape (n, 3).
        triangles: Shape (m, 3).
        moves: Whether the fluid carries it.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    moves: bool


def find_footage(scene: Scene) -> Shot | None:
    """Open the footage that a run was made from, or that the run it simulates was made from; None if there was none.

    Raises:
        ValueError: If it is not where it was, or not as it was.
        OSError: If it cannot be read.
    """
    document = scene.volumes.document or {}
    for _ in range(8):  # runs of runs
        if document.get("views") or not document.get("source"):
            break
        source = Path(document["source"])
        document = Run(source).settings() if (source / SETTINGS).is_file() else {}
    if not document.get("views"):
        return None
    options = document.get("input", {}) | {"frames": format_frames(scene.frames)}
    return open_shot(document["views"], InputOptions(**options))


def find_solids(scene: Scene, shape: tuple[int, int, int]) -> dict[int, list[Solid]]:
    """Return obstacles and bodies of a simulated run by frame; frames without any are left out.

    Args:
        scene: The run.
        shape: Voxels of its volumes (x, z, y).

    Raises:
        ValueError: If a file of them is damaged or gone.
        OSError: If it cannot be read.
    """
    from warpfluid.simulation.placing import Placing

    document, placing = scene.volumes.document or {}, Placing(shape, 1.0)
    obstacles = [make_thing("obstacle", table, where="run.toml: ") for table in document.get("obstacle", ())]
    bodies = [
        placing.body(make_thing("body", table, where="run.toml: "), scene.frames[0])
        for table in document.get("body", ())
    ]
    poses = read_bodies(Run(scene.volumes.name).folder / BODIES)[1] if bodies else {}
    found = {}
    for frame in scene.frames:
        solids = [_obstacle(placing.solid(options, frame, frame)) for options in obstacles]
        solids += [
            _body(body, pose, placing, scene.volumes.output.voxel_size)
            for body, pose in zip(bodies, poses.get(frame, ()), strict=False)
        ]
        found |= {frame: solids} if solids else {}
    return found


def _body(body, pose: dict[str, np.ndarray], placing, voxel: float) -> Solid:
    """Return a body where the file of bodies says it is, which counts in scene units from the middle of the floor."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_quat(pose["quaternion"]).apply(body.vertices)
    return Solid(turned + pose["position"] / voxel + placing.origin, body.triangles, True)


def _obstacle(placed) -> Solid:
    """Return the surface of an obstacle."""
    from warpfluid.simulation.shapes import Box, Cylinder, Mesh
    from warpfluid.simulation.triangles import box_surface

    shape = placed.shape
    if isinstance(shape, Box):
        vertices, triangles = box_surface(shape.size)
    elif isinstance(shape, Mesh):
        vertices, triangles = shape.vertices, shape.triangles
    else:
        vertices, triangles = _round(shape.radius, shape.height if isinstance(shape, Cylinder) else None)
    return Solid(vertices @ placed.rotation.T + placed.centre, triangles, False)


def _round(radius: float, height: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface of a sphere, or of an upright cylinder."""
    import pyvista

    if height is None:
        surface = pyvista.Sphere(radius=radius)
    else:
        surface = pyvista.Cylinder(radius=radius, height=height, direction=(0, 1, 0), resolution=48).triangulate()
    return np.array(surface.points, np.float64), np.array(surface.regular_faces)
